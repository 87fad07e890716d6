"""Contact wrenches carry the whole impulse: force times interval, summed, is the momentum gained."""

from pathlib import Path

import numpy as np
import pytest
from geometry_msgs.msg import WrenchStamped
from harness import wait_for
from nav_msgs.msg import Odometry
from std_srvs.srv import Trigger

MASS, GRAVITY, INTERVAL, STEPS = 2.0, 10.0, 0.05, 1500
HALF = np.array([0.3, 0.2, 0.1])
INERTIA = MASS / 3.0 * (np.sum(HALF**2) - HALF**2)  # principal moments of the box
SCENE = f"""
dt: 0.001
gravity: [0, 0, {-GRAVITY}]
bodies:
  - {{name: ground, type: static, shape: {{type: half_space, normal: [0, 0, 1], offset: 0}}, restitution: 0.4}}
  - name: die
    shape: {{type: box, half_extents: {HALF.tolist()}}}
    mass: {MASS}
    position: [0, 0, 0.6]
    orientation: [0.2, 0.4, 0.4, 0.8]
    linear_velocity: [0.7, -0.2, 0]
    angular_velocity: [1, 2, 3]
"""
TOPICS = """
topics:
  - name: ~/bodies/NAME/contact_wrench
    content: contact_wrench
    type: geometry_msgs/msg/WrenchStamped
    direction: out
    frame: FRAME
    rate: 20
    qos: {depth: 100}
  - name: ~/bodies/NAME/odom
    content: odometry
    type: nav_msgs/msg/Odometry
    direction: out
    rate: 20
    qos: {depth: 100}
"""


def rotation(q) -> np.ndarray:
    x, y, z, w = q.x, q.y, q.z, q.w
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def xyz(vector) -> np.ndarray:
    return np.array([vector.x, vector.y, vector.z])


def momenta(odometry: Odometry) -> tuple[np.ndarray, np.ndarray]:
    """Linear and angular momentum in world axes; the twist is in the body frame."""
    turn = rotation(odometry.pose.pose.orientation)
    twist = odometry.twist.twist
    return MASS * turn @ xyz(twist.linear), turn @ (INERTIA * xyz(twist.angular))


@pytest.mark.parametrize("frame", ["NAME/com", "world", "NAME"])
def test_the_sum_of_wrenches_is_the_change_of_momentum(simulator, tmp_path: Path, frame):
    (tmp_path / "die.yaml").write_text(SCENE)
    (tmp_path / "topics.yaml").write_text(TOPICS.replace("FRAME", frame))
    sim = simulator(
        scene=tmp_path / "die.yaml",
        topics=tmp_path / "topics.yaml",
        start_paused=True,
        step_count=STEPS,
    )
    wrenches = sim.client.collect(WrenchStamped, "/sim_node/bodies/die/contact_wrench")
    odometry = sim.client.collect(Odometry, "/sim_node/bodies/die/odom")
    wait_for(lambda: wrenches and odometry, "the state at time 0, shown to newcomers")
    assert sim.client.call(Trigger, "/sim_node/step").success
    count = round(STEPS * 1e-3 / INTERVAL)
    stamped = wait_for(lambda: at_intervals(wrenches, count), "every wrench")
    states = wait_for(lambda: at_intervals(odometry, count), "every state")
    impulse, angular_impulse = np.zeros(3), np.zeros(3)
    hits = 0
    for key in range(1, count + 1):
        wrench = stamped[key].wrench
        force, torque = xyz(wrench.force), xyz(wrench.torque)
        assert stamped[key].header.frame_id == frame.replace("NAME", "die")
        if frame != "world":  # expressed in the frame as it stands at the stamp
            turn = rotation(states[key].pose.pose.orientation)
            force, torque = turn @ force, turn @ torque
        impulse += force * INTERVAL
        angular_impulse += torque * INTERVAL
        hits += bool(np.any(force))
    (p0, l0), (p1, l1) = momenta(states[0]), momenta(states[count])
    weight = np.array([0.0, 0.0, -MASS * GRAVITY]) * count * INTERVAL
    assert 3 < hits < count  # it flies, bounces and rests
    # 1e-9 of the 30 N s of weight: rounding over 1500 steps and of quaternions in double
    np.testing.assert_allclose(impulse, p1 - p0 - weight, atol=3e-8)
    if frame != "NAME":  # about the body's origin, which is the centre of mass here as well
        np.testing.assert_allclose(angular_impulse, l1 - l0, atol=3e-9)  # the same, 0.3 m of arm


def at_intervals(messages, count):
    """Messages by their number of the interval, once all have come."""
    found = {
        round((m.header.stamp.sec + m.header.stamp.nanosec * 1e-9) / INTERVAL): m for m in messages
    }
    return found if len(found) == count + 1 else None


def test_a_resting_crate_weighs_what_it_weighs(simulator):
    sim = simulator(start_paused=True, step_count=500)
    wrenches = sim.client.collect(WrenchStamped, "/sim_node/bodies/crate/contact_wrench")
    wait_for(lambda: wrenches, "the first wrench")
    assert sim.client.call(Trigger, "/sim_node/step").success
    wait_for(lambda: wrenches[-1].header.stamp.nanosec == 500_000_000, "the last wrench")
    # The state at time 0 is shown again to every subscriber that turns up.
    moving = [m for m in wrenches if m.header.stamp.nanosec or m.header.stamp.sec]
    assert len(moving) > 10
    for message in moving:
        assert message.header.frame_id == "crate/com"
        # m g = 20 N; solved to rounding (relative residual at most 1e-12)
        np.testing.assert_allclose(xyz(message.wrench.force), (0.0, 0.0, 20.0), atol=1e-9)
        np.testing.assert_allclose(xyz(message.wrench.torque), 0.0, atol=1e-9)
