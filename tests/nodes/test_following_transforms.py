"""Kinematic bodies that follow /tf: their velocity is that of the motion, and what they touch feels it."""

import math

import numpy as np
import pytest
from rb_physics_nodes.inputs import Inputs

import rb_physics as rb
from rb_physics.recording.encoders import PoseStampedEncoder, TransformEncoder
from rb_physics.recording.operations import Operations
from rb_physics.recording.topics import Qos, Topic

DT = 0.001
TF = Topic("/tf", "cmd_tf", "tf2_msgs/msg/TFMessage", "in", "arm/NAME", bodies=("link",))
LATCHED = Qos(durability="transient_local")
STATIC = Topic("/tf_static", "cmd_tf", "tf2_msgs/msg/TFMessage", "in", "arm/NAME", qos=LATCHED)
POSE = Topic("/link/cmd_pose", "cmd_pose", "geometry_msgs/msg/PoseStamped", "in", body="link")


class Scene:
    """A kinematic link, and a crate on top of it or in front of it."""

    def __init__(self, link=(2.0, 0.5, 0.1), crate=(0.0, 0.0, 0.2)):
        self.world = rb.World(gravity=(0, 0, -10), dt=DT)
        self.link = self.world.add_body(rb.Box(link), type="kinematic", name="link", friction=0.4)
        self.crate = self.world.add_body(
            rb.Box((0.1, 0.1, 0.1)), mass=1.0, name="crate", position=crate, friction=0.4
        )
        self.said = []
        self._operations = Operations(self.world)
        self.inputs = Inputs(self.world, [TF, STATIC, POSE], 0.1, 0.5, False,
                             lambda key, text: self.said.append(text))  # fmt: skip

    def perform(self, name, **arguments):
        self._operations.perform(name, arguments)

    def send(self, parent, child, transform, topic="/tf"):
        data = TransformEncoder([parent], [child]).encode(round(self.world.time * 1e9), [transform])
        self.inputs.inbox.put(topic, data)

    def step(self, count=1):
        for _ in range(count):
            step = self.world.step_count
            self.inputs.receive(self.world, step, self.perform)
            self.inputs.apply(self.world, step, self.perform)
            self.world.step()


def place(x=0.0, y=0.0, z=0.0, yaw=0.0):
    return [x, y, z, 0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)]


def test_a_crate_rides_along_on_a_link_with_coulomb_friction():
    """The belt moves at 0.5 m/s: the crate is accelerated by mu g = 4 m/s² and then keeps up."""
    scene = Scene()
    scene.send("world", "arm/base", place(z=1.0), "/tf_static")
    scene.step()
    for k in range(30):  # a stream at 50 Hz
        scene.send("arm/base", "arm/link", place(x=0.01 * k, z=-1.0))
        scene.step(20)
        if k == 0:
            assert not scene.link.linear_velocity.any()  # put there, without having moved
        else:
            # 0.01 m in 20 ms; rounding of the difference of two positions over the time
            assert scene.link.linear_velocity[0] == pytest.approx(0.5, abs=1e-12)
    # It slipped for v / (mu g) = 0.125 s behind the start of the motion, and is carried since.
    assert scene.crate.linear_velocity[0] == pytest.approx(0.5, abs=1e-9)
    slip = scene.link.position[0] - scene.crate.position[0]
    assert slip == pytest.approx(0.5 * 0.125 / 2, abs=1e-6)  # v t / 2; solver residual


def test_a_link_hits_with_its_velocity():
    """Restitution 1 between a moving wall and a ball at rest: the ball leaves at twice its speed."""
    world = rb.World(gravity=(0, 0, 0), dt=DT)
    scene = Scene()
    scene.world = world
    world.add_body(rb.Box((0.1, 0.5, 0.5)), type="kinematic", name="link")
    ball = world.add_body(
        rb.Sphere(0.1), mass=1.0, name="ball", position=(0.25, 0, 0), restitution=1.0, friction=0.0
    )
    scene._operations = Operations(world)
    scene.inputs = Inputs(world, [TF, STATIC], 0.1, 0.5, False, lambda key, text: None)
    for k in range(6):
        scene.send("world", "arm/link", place(x=0.02 * k))
        scene.step(20)
    assert ball.linear_velocity[0] == pytest.approx(2.0, abs=1e-9)  # 1 m/s from 0.02 m in 20 ms


def test_where_the_stream_ends_the_link_stops_at_the_last_pose():
    scene = Scene()
    for k in range(4):
        scene.send("world", "arm/link", place(x=0.01 * k, yaw=0.1 * k))
        scene.step(20)
    scene.step(60)
    np.testing.assert_allclose(scene.link.position, (0.03, 0.0, 0.0), atol=1e-15)
    np.testing.assert_allclose(scene.link.orientation, place(yaw=0.3)[3:], atol=1e-15)
    assert not scene.link.linear_velocity.any()
    assert not scene.link.angular_velocity.any()


def test_a_jump_after_a_gap_moves_nothing_else():
    scene = Scene()
    scene.send("world", "arm/link", place())
    scene.step(700)
    scene.send("world", "arm/link", place(y=3.0))  # away from under the crate
    scene.step()
    assert scene.link.position[1] == 3.0
    assert not scene.link.linear_velocity.any()
    np.testing.assert_allclose(scene.crate.linear_velocity[:2], 0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("parent", "transform", "words"),
    [
        ("elsewhere", place(), "no transform leads from 'elsewhere' to 'world'"),
        ("arm/link", place(), "go in a circle"),
        ("world", place(x=math.nan), "it must be finite"),
        ("world", [0, 0, 0, 0, 0, 0, 2.0], "norm of the quaternion of 'arm/link' is 2"),
    ],
)
def test_transforms_that_lead_nowhere_are_told(parent, transform, words):
    scene = Scene()
    scene.send(parent, "arm/link", transform)
    scene.step()
    assert words in scene.said[0]
    assert not scene.link.position.any()


def test_the_nodes_own_transforms_are_passed_over():
    scene = Scene()
    scene.send("world", "crate", place(x=7.0))
    scene.step()
    assert scene.inputs.counters["ignored"] == 1
    assert scene.inputs.counters["accepted"] == 0


def test_malformed_transforms_are_refused():
    scene = Scene()
    scene.inputs.inbox.put("/tf", b"\x00\x01\x00\x00\xff\xff\xff\xff")
    scene.inputs.inbox.put("/tf", b"")
    scene.step()
    assert scene.inputs.counters["refused_malformed"] == 2


def test_a_stream_of_poses_stamped_with_their_present_has_the_velocity_of_the_motion():
    scene = Scene()
    encoder = PoseStampedEncoder(["world"])
    for k in range(10):
        pose = encoder.encode(round(scene.world.time * 1e9), [place(x=0.01 * k)])[0]
        scene.inputs.inbox.put(POSE.name, pose)
        scene.step(19)
        if k > 0:  # from the second one on it is known to be a stream
            assert scene.link.linear_velocity[0] == pytest.approx(0.5, abs=1e-12)
        scene.step(1)
        assert scene.link.position[0] == pytest.approx(0.01 * k, abs=1e-15)
