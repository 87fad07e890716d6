"""The ROS 2 nodes of rb_physics, installed as rb_physics_nodes. Only here is rclpy imported."""
