"""Small nodes that use the simulator as any robot node would: through topics only.

Each runs with ``python -m rb_physics_nodes.examples.NAME --ros-args -p PARAMETER:=VALUE``.
"""
