"""Lockstep: two runs with two external publishers give the same state hash at every step."""

from pathlib import Path

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Wrench, WrenchStamped
from harness import Client, wait_for
from rosbags.highlevel import AnyReader
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import MultiDOFJointState
from std_srvs.srv import Trigger

from rb_physics.recording.decoders import decode_multi_array

STEPS = 150
SCENE = """
dt: 0.002
bodies:
  - {name: ground, type: static, shape: {type: half_space, normal: [0, 0, 1], offset: 0}}
  - {name: a, shape: {type: box, half_extents: [0.1, 0.1, 0.1]}, mass: 1, position: [0, 0, 0.1]}
  - {name: b, shape: {type: box, half_extents: [0.1, 0.1, 0.1]}, mass: 1, position: [0.3, 0, 0.1]}
"""


class Controller:
    """Answers every /clock with a wrench for the step that starts then."""

    def __init__(self, domain: int, body: str, amplitude: float) -> None:
        self.client = Client(domain, f"controller_{body}")
        self._amplitude = amplitude
        self.publisher = self.client.publisher(WrenchStamped, f"/sim_node/bodies/{body}/wrench")
        self.client.node.create_subscription(Clock, "/clock", self.answer, 10)

    def answer(self, clock: Clock) -> None:
        time = clock.clock.sec + clock.clock.nanosec * 1e-9
        if time >= STEPS * 0.002:
            return
        message = WrenchStamped()
        message.header.stamp = clock.clock
        message.header.frame_id = "world"
        message.wrench.force.x = self._amplitude * (1.0 + 7.0 * time)
        message.wrench.torque.z = 0.3 * time
        self.publisher.publish(message)


def hashes(bag: Path) -> list[tuple[int, int]]:
    rows = []
    with AnyReader([bag]) as reader:
        for connection, _, data in reader.messages():
            if connection.topic == "/sim_node/state_hash":
                rows.extend(map(tuple, decode_multi_array(data, "u8")[1].tolist()))
    return rows


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE)
    return path


def run(simulator, domain, record_dir: Path) -> list[tuple[int, int]]:
    sim = simulator(lockstep=True, record_dir=record_dir)
    clock = sim.client.collect(Clock, "/clock")
    controllers = [Controller(domain, "a", 4.0), Controller(domain, "b", -4.0)]
    try:
        last = round(STEPS * 0.002 * 1e9)
        wait_for(
            lambda: clock and clock[-1].clock.nanosec + clock[-1].clock.sec * 10**9 == last,
            "all steps",
        )
    finally:
        for controller in controllers:
            controller.client.close()
    assert sim.node.stop() == 0
    simulator.close()
    (bag,) = record_dir.iterdir()
    return hashes(bag)


def test_two_runs_have_the_same_hash_at_every_step(simulator, domain, tmp_path):
    first = run(simulator, domain, tmp_path / "first")
    second = run(simulator, domain, tmp_path / "second")
    assert [step for step, _ in first] == list(range(1, STEPS + 1))
    assert first == second
    assert len({value for _, value in first}) == STEPS  # the wrenches keep changing the state


def test_other_stamps_are_refused_and_counted_and_step_advances(simulator):
    sim = simulator(lockstep=True, step_count=3)
    diagnostics = sim.client.collect(DiagnosticArray, "/sim_node/diagnostics")
    publisher = sim.client.publisher(WrenchStamped, "/sim_node/bodies/a/wrench")
    message = WrenchStamped()
    message.header.frame_id = "world"
    message.header.stamp.sec = 5
    publisher.publish(message)
    wait_for(lambda: "5000000000 ns, but the next step starts at 0 ns" in sim.node.output, "a line")
    assert sim.client.call(Trigger, "/sim_node/step").message == "at step 3, time 0.006 s"
    for _ in range(250):  # up to 1.5 s, past the diagnostics of 1 s
        sim.client.call(Trigger, "/sim_node/step")

    def refused():
        return [
            item.value
            for message in diagnostics
            for status in message.status
            if status.name == "sim_node: inputs"
            for item in status.values
            if item.key == "refused_stamp"
        ][-1:]

    wait_for(lambda: refused() == ["1"], "the refusal counted")


class BatchController(Controller):
    """Answers every /clock with one message for both bodies."""

    def __init__(self, domain: int) -> None:
        self.client = Client(domain, "controller_of_both")
        self.publisher = self.client.publisher(MultiDOFJointState, "/sim_node/wrenches")
        self.client.node.create_subscription(Clock, "/clock", self.answer, 10)

    def answer(self, clock: Clock) -> None:
        time = clock.clock.sec + clock.clock.nanosec * 1e-9
        message = MultiDOFJointState(joint_names=["a", "b"])
        message.header.stamp = clock.clock
        message.header.frame_id = "world"
        for amplitude in (4.0, -4.0):
            wrench = Wrench()
            wrench.force.x, wrench.torque.z = amplitude * (1.0 + 7.0 * time), 0.3 * time
            message.wrench.append(wrench)
        self.publisher.publish(message)


def test_a_batch_stands_in_for_the_topics_of_its_bodies(simulator, domain, tmp_path):
    """One controller of both bodies by batch gives the bits that two controllers give."""
    first = run(simulator, domain, tmp_path / "two")
    sim = simulator(lockstep=True, record_dir=tmp_path / "batch")
    clock = sim.client.collect(Clock, "/clock")
    controller = BatchController(domain)
    try:
        last = round(STEPS * 0.002 * 1e9)
        wait_for(lambda: clock and seconds(clock[-1]) >= last, "all steps")
    finally:
        controller.client.close()
    assert sim.node.stop() == 0
    (bag,) = (tmp_path / "batch").iterdir()
    with AnyReader([bag]) as reader:
        poses = [d for c, _, d in reader.messages() if c.topic == "/sim_node/poses"]
    (other,) = (tmp_path / "two").iterdir()
    with AnyReader([other]) as reader:
        expected = [d for c, _, d in reader.messages() if c.topic == "/sim_node/poses"]
    # Its source has another number, so hashes differ; the motion is the same to the bit.
    assert len(expected) > STEPS // 10
    assert poses[: len(expected)] == expected
    assert len(first) == STEPS


def seconds(clock: Clock) -> int:
    return clock.clock.nanosec + clock.clock.sec * 10**9


def test_a_body_whose_batch_and_own_topic_both_deliver_is_refused_the_second(simulator):
    sim = simulator(lockstep=True)
    batch = sim.client.publisher(MultiDOFJointState, "/sim_node/wrenches")
    single = sim.client.publisher(WrenchStamped, "/sim_node/bodies/a/wrench")
    message = MultiDOFJointState(joint_names=["a"], wrench=[Wrench()])
    message.header.frame_id = "world"
    batch.publish(message)
    own = WrenchStamped()
    own.header.frame_id = "world"
    single.publish(own)
    wait_for(lambda: "was already delivered" in sim.node.output, "a line about it")
