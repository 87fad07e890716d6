"""Namespaces, remaps, QoS that doesn't match, twins and crowds on the graph."""

from geometry_msgs.msg import PoseArray, WrenchStamped
from harness import NodeProcess, operations_on, parameters, wait_for
from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String
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


def test_a_publisher_of_another_type_is_named(simulator):
    sim = simulator()
    sim.client.node.create_publisher(PoseArray, WRENCH, 10)
    wait_for(
        lambda: (
            (
                f"publisher /test_client on {WRENCH} is not heard: its type is "
                "geometry_msgs/msg/PoseArray, the topic's is geometry_msgs/msg/WrenchStamped"
            )
            in sim.node.output
        ),
        "a line about it",
    )


def test_ten_publishers_on_one_body_are_reported_and_the_last_message_counts(simulator):
    sim = simulator(wrench_timeout=-1.0)
    operations = sim.client.collect(String, "/sim_node/operations")
    publishers = [sim.client.publisher(WrenchStamped, WRENCH) for _ in range(10)]
    message = WrenchStamped()
    message.header.frame_id = "world"
    for k in range(200):
        message.wrench.force.x = float(k)
        publishers[k % 10].publish(message)
    wait_for(lambda: f"10 publishers on {WRENCH}" in sim.node.output, "a line about it")

    def all_accounted_for():
        applied = operations_on(operations, "apply_wrench")
        return applied and applied[-1]["arguments"]["force"][0] >= 190.0 and applied

    applied = wait_for(all_accounted_for, "the last messages to act")
    assert {operation["arguments"]["source"] for operation in applied} == {0}  # none adds up


def test_a_deadline_and_a_liveliness_that_are_not_offered_are_named(simulator):
    sim = simulator()
    for profile in (
        QoSProfile(depth=1, deadline=Duration(nanoseconds=10**7)),
        QoSProfile(
            depth=1,
            liveliness=LivelinessPolicy.MANUAL_BY_TOPIC,
            liveliness_lease_duration=Duration(seconds=1),
        ),
    ):
        sim.client.node.create_subscription(PoseArray, "/sim_node/poses", lambda _: None, profile)
    for policy in ("DEADLINE", "LIVELINESS"):
        words = f"on /sim_node/poses gets no messages: incompatible policy: {policy}"
        wait_for(lambda words=words: words in sim.node.output, "a line about it")


def test_a_publisher_for_no_body_and_a_second_clock_are_told(simulator):
    sim = simulator()
    sim.client.node.create_publisher(WrenchStamped, "/sim_node/bodies/crete/wrench", 10)
    sim.client.node.create_publisher(Clock, "/clock", 10)
    words = "there is no body 'crete'; there are ground, crate, floater"
    wait_for(lambda: words in sim.node.output, "a line about the body")
    wait_for(lambda: "another publisher on /clock" in sim.node.output, "a line about the clock")
