"""What `rb_physics info` says is true of every step, not of those that were sent."""

import pytest

import rb_physics as rb
from rb_physics.recording import Recorder, load_topics
from rb_physics.recording.log_reader import Recording
from rb_physics.recording.summary import summary
from rb_physics.recording.topics import parse_topics

TOTALS = """topics:
  - {name: ~/totals, content: totals, type: std_msgs/msg/Float64MultiArray, direction: out, rate: 7}
  - {name: ~/often, content: totals, type: std_msgs/msg/Float64MultiArray, direction: out, rate: 100}
"""


def falling():
    """A box that hits the ground on an edge within the run: contacts for few of the steps."""
    world = rb.World()
    world.add_body(rb.HalfSpace(), type="static", name="ground")
    world.add_body(
        rb.Box((0.1, 0.1, 0.1)),
        mass=1.0,
        position=(0, 0, 0.16),
        orientation=rb.math.quaternion_from_rotation_vector((0.6, 0, 0)),
        restitution=0.6,
    )
    return world


@pytest.mark.parametrize("steps", [140, 250])
def test_up_to_is_the_largest_of_all_steps(tmp_path, steps):
    twin, worst = falling(), [0.0, 0.0, 0]
    for _ in range(steps):
        twin.step()
        stats = twin.stats
        worst = [
            max(worst[0], stats.residual),
            max(worst[1], stats.max_penetration),
            max(worst[2], stats.contacts),
        ]
    world = falling()
    with Recorder(world, tmp_path / "run", topics=parse_topics(TOTALS)) as recorder:
        world.step(steps - 3)
        recorder.after_step()
        world.step(3)
        recorder.after_step()
    assert worst[2] > 0
    text = summary(tmp_path / "run")
    assert f"residual up to {worst[0]:.1e}, penetration up to {worst[1]:.1e} m" in text
    assert f"up to {worst[2]} contacts" in text
    # A torn bag has the totals only; they tell of the steps before them.
    log = Recording(tmp_path / "run")
    rows = [m for m in log.messages() if m.topic == "/sim_node/often"]
    assert len(rows) >= 2


def test_each_reader_has_the_worst_since_it_asked_last():
    world = falling()
    table = load_topics()
    with Recorder(world, None, topics=table) as recorder:
        recorder.outputs.worst.open("one")
        recorder.outputs.worst.open("other")
        world.step(400)
        one = recorder.outputs.worst.take("one")
        assert one[2] > 0
        assert recorder.outputs.worst.take("one") == (0.0, 0.0, 0)
        assert recorder.outputs.worst.take("other") == one
    assert world.drain_worst() == (0.0, 0.0, 0)
