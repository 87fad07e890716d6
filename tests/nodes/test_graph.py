"""Namespaces, remaps, QoS that doesn't match, twins and crowds on the graph."""

from geometry_msgs.msg import PoseArray, WrenchStamped
from harness import NodeProcess, parameters, wait_for
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_srvs.srv import Trigger

WRENCH = "/sim_node/bodies/floater/wrench"


def test_namespace_and_remaps(client, domain, scene):
    arguments = [*parameters(scene=scene, start_paused=True), "-r", "__ns:=/robot"]
    arguments += ["-r", "__node:=world_1", "-r", "~/poses:=/somewhere/poses"]
    node = NodeProcess("rb_physics_nodes.sim_node", arguments, domain)
    try:
        poses = client.collect(PoseArray, "/somewhere/poses")
        wait_for(lambda: poses, "poses on the remapped topic")
        assert client.call(Trigger, "/robot/world_1/step").success
        client.publisher(WrenchStamped, "/robot/world_1/bodies/floater/wrench")
    finally:
        node.close()


def test_incompatible_subscriber_and_publisher_are_named_with_the_policy(simulator):
    sim = simulator()
    node = sim.client.node
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    node.create_subscription(PoseArray, "/sim_node/poses", lambda _: None, latched)
    wait_for(lambda: "incompatible policy: DURABILITY" in sim.node.output, "a line about poses")
    unreliable = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    node.create_publisher(WrenchStamped, WRENCH, unreliable)
    wait_for(lambda: "incompatible policy: RELIABILITY" in sim.node.output, "one about wrenches")


def test_a_second_publisher_on_a_topic_is_reported(simulator):
    sim = simulator()
    sim.client.publisher(WrenchStamped, WRENCH)
    sim.client.publisher(WrenchStamped, WRENCH)
    wait_for(lambda: f"2 publishers on {WRENCH}" in sim.node.output, "a line about it")


def test_a_node_of_the_same_name_is_reported(simulator):
    first, second = simulator(), simulator()
    wait_for(
        lambda: "another node is called /sim_node" in first.node.output + second.node.output,
        "a line about it",
    )
