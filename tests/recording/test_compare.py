"""What compare says of orientations, velocities and states, where positions say nothing."""

from __future__ import annotations

import json
import math

import pytest
from click.testing import CliRunner

import rb_physics as rb
from rb_physics.cli import main
from rb_physics.recording import Recorder
from rb_physics.recording.compare import compare, differences
from rb_physics.recording.plot import plot_comparison
from rb_physics.recording.topics import parse_topics

TOPICS = """topics:
  - {name: ~/poses, content: poses, type: geometry_msgs/msg/PoseArray, direction: out}
  - {name: ~/body_names, content: body_names, type: std_msgs/msg/String, direction: out}
  - {name: ~/bodies/NAME/odom, content: odometry, type: nav_msgs/msg/Odometry, direction: out, bodies: "*"}
"""


def recorded(directory, steps=50, topics=None, **motion):
    """A free ball, without gravity, of which nothing is different but `motion`."""
    body = {"name": "ball", "shape": {"type": "sphere", "radius": 0.1}, "mass": 2.0, **motion}
    scene = rb.Scene.from_yaml(json.dumps({"gravity": [0, 0, 0], "dt": 0.002, "bodies": [body]}))
    world = scene.build()
    with Recorder(world, directory, scene=scene, topics=topics) as recorder:
        for _ in range(steps):
            world.step()
            recorder.after_step()
    return directory


def turned(angle: float) -> list[float]:
    return [0.0, math.sin(angle / 2), 0.0, math.cos(angle / 2)]


@pytest.mark.parametrize("angle", [1e-9, 0.3, 3.1])
def test_an_orientation_alone_is_named_with_its_angle(tmp_path, angle):
    first = recorded(tmp_path / "a", orientation=turned(0.2))
    second = recorded(tmp_path / "b", orientation=turned(0.2 + angle))
    result = compare(first, second)
    [ball] = result.bodies
    position, orientation = ball.differences
    assert (position.parts_at, position.largest) == (None, 0.0)
    assert orientation.parts_at == 0.0
    # Quaternions hold 1e-16 of a turn.
    assert orientation.largest == pytest.approx(angle, abs=1e-15)
    assert ball.largest_angle == orientation.largest
    assert not result.identical
    assert "they part at 0.000 s, body ball first: orientation\n" in result.text
    assert f"{angle:.3g} rad" in result.text
    assert "position" not in result.text


def test_a_quaternion_and_its_negative_are_one_orientation(tmp_path):
    first = recorded(tmp_path / "a", orientation=turned(0.2))
    second = recorded(tmp_path / "b", orientation=[-c for c in turned(0.2)])
    assert compare(first, second).identical


def test_velocities_are_compared_in_world_axes_where_both_logged_them(tmp_path):
    topics = parse_topics(TOPICS)
    start = {"orientation": turned(1.0)}
    first = recorded(
        tmp_path / "a",
        topics=topics,
        linear_velocity=[1, 0, 0],
        angular_velocity=[0, 0, 1],
        **start,
    )
    second = recorded(
        tmp_path / "b",
        topics=topics,
        linear_velocity=[1, 0, 0.25],
        angular_velocity=[0, 0, 1.5],
        **start,
    )
    result = compare(first, second)
    [ball] = result.bodies
    apart = {d.quantity: d.last for d in ball.differences}
    # After 0.1 s of free motion, exact but for rounding.
    assert apart == pytest.approx(
        {"position": 0.025, "orientation": 0.05, "linear velocity": 0.25, "angular velocity": 0.5},
        abs=1e-13,
    )
    parted = {d.quantity: d.parts_at for d in ball.differences}
    assert parted == {
        "position": 0.002, "orientation": 0.002, "linear velocity": 0.0, "angular velocity": 0.0
    }  # fmt: skip
    assert "body ball first: linear velocity, angular velocity" in result.text
    assert "0.25 m/s" in result.text
    assert "0.5 rad/s" in result.text
    assert list(differences(first, second)["ball"]) == list(apart)
    same = compare(first, first)
    assert same.identical
    assert same.text.endswith("identical velocities\nidentical poses")
    third = recorded(tmp_path / "c", **start)  # has none
    assert [d.quantity for d in compare(first, third).bodies[0].differences] == [
        "position",
        "orientation",
    ]


def test_state_hashes_tell_the_very_step(tmp_path):
    first, other = tmp_path / "a", tmp_path / "b"
    for directory, push in ((first, None), (other, 7)):
        scene = rb.load_scene("single_box")
        world = scene.build()
        with Recorder(world, directory, scene=scene) as recorder:
            for step in range(40):
                if step == push:
                    recorder.perform("apply_wrench", body="box", force=(30, 0, 0), duration=0.01)
                world.step()
                recorder.after_step()
    result = compare(first, other)
    dt = rb.load_scene("single_box").build().settings.dt
    assert result.states_part_at == pytest.approx(8 * dt, rel=1e-12)  # rounding of a product
    assert f"their states part in the step that ends at {8 * dt:g} s" in result.text
    assert compare(first, first).states_part_at is None


def test_the_picture_of_an_orientation_alone_shows_it(tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    from matplotlib import pyplot

    first = recorded(tmp_path / "a", angular_velocity=[0, 0, 1])
    second = recorded(tmp_path / "b", angular_velocity=[0, 0, 2])
    kept = []
    monkeypatch.setattr(pyplot, "close", kept.append)
    plot_comparison(first, second, tmp_path / "c.png")
    monkeypatch.undo()
    position, orientation = kept[0].axes
    assert [t.get_text() for t in position.texts] == ["no difference"]
    assert "[m]" in position.get_ylabel()
    assert "[rad]" in orientation.get_ylabel()
    assert len(orientation.texts) == 0
    [line] = orientation.lines
    time, angle = line.get_data()
    assert angle[1:] == pytest.approx(time[1:], abs=1e-13)  # 1 rad/s apart; rounding
    pyplot.close(kept[0])
    answer = CliRunner().invoke(
        main, ["compare", str(first), str(second), "--plot", str(tmp_path / "d.png")]
    )
    assert answer.exit_code == 1
    assert "identical" not in answer.output.replace("0 other bodies are identical", "")
