"""What a robot's process reads of contacts: a pair's wrench, a sensor's view, a force plate."""

from pathlib import Path

import pytest
from geometry_msgs.msg import WrenchStamped
from harness import wait_for

SCENE = """
gravity: [0, 0, -10]
bodies:
  - {name: plate, type: static, shape: {type: box, half_extents: [1, 1, 0.1]}, position: [0, 0, -0.1]}
  - name: lower
    shape: {type: box, half_extents: [0.1, 0.1, 0.1]}
    mass: 2
    position: [0, 0, 0.1]
    frames: {wrist: {position: [0, 0.1, 0], orientation: [0.7071067811865476, 0, 0, 0.7071067811865476]}}
  - {name: upper, shape: {type: box, half_extents: [0.05, 0.05, 0.05]}, mass: 1, position: [0, 0, 0.25]}
"""
WRENCH = "type: geometry_msgs/msg/WrenchStamped, direction: out, rate: 50"
TOPICS = f"""
topics:
  - {{name: ~/bodies/NAME/by/OTHER, content: pair_wrench, {WRENCH}, bodies: [lower], others: all, frame: world}}
  - {{name: ~/bodies/NAME/sensor, content: contact_wrench, {WRENCH}, bodies: [lower], frame: NAME/wrist}}
  - {{name: ~/bodies/NAME/plate, content: contact_wrench, {WRENCH}, bodies: [plate], frame: world, reference_point: upper}}
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    (tmp_path / "topics.yaml").write_text(TOPICS)
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE)
    return path


def test_pairs_sensors_and_force_plates(simulator, scene: Path):
    sim = simulator(topics=scene.with_name("topics.yaml"))
    topics = ["lower/by/plate", "lower/by/upper", "lower/sensor", "plate/plate"]
    seen = [sim.client.collect(WrenchStamped, f"/sim_node/bodies/{topic}") for topic in topics]

    def settled():
        return all(seen) and all(
            messages[-1].header.stamp.sec + messages[-1].header.stamp.nanosec * 1e-9 > 0.2
            for messages in seen
        )

    wait_for(settled, "wrenches of bodies at rest")
    below, above, sensor, plate = (messages[-1] for messages in seen)
    # At rest: the plate carries 3 kg, the upper box presses with its 1 kg. 1e-9: solver residual
    assert below.wrench.force.z == pytest.approx(30.0, abs=1e-9)
    assert above.wrench.force.z == pytest.approx(-10.0, abs=1e-9)
    # The wrist is turned a quarter about x (its y is up) and lies 0.1 m along y from the centre:
    # the net 20 N act through the centre, so their moment about the wrist is -0.1 m x 20 N about x.
    assert sensor.header.frame_id == "lower/wrist"
    assert sensor.wrench.force.y == pytest.approx(20.0, abs=1e-9)
    assert sensor.wrench.torque.x == pytest.approx(-2.0, abs=1e-9)
    assert plate.header.frame_id == "world"
    assert plate.wrench.force.z == pytest.approx(-30.0, abs=1e-9)
    assert plate.wrench.torque.x == pytest.approx(0.0, abs=1e-9)
