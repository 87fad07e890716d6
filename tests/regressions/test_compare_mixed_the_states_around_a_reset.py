"""A node shows the world before and after a reset at one log time; compare took the last pose of
each time, so that a branch, which shows one of them, seemed to part from its recording there."""

import pytest

import rb_physics as rb
from rb_physics.recording import Recorder
from rb_physics.recording.branch import branch
from rb_physics.recording.compare import compare
from rb_physics.recording.replay import verify

CRATE = {"name": "crate", "shape": {"type": "box", "half_extents": [0.1] * 3}, "mass": 1.0,
         "position": [0, 3, 1]}  # fmt: skip
OPERATIONS = {
    "reset_state": [("reset_state", {})],
    "reset": [("reset", {})],
    "spawn": [("add_body", {"description": CRATE})],
    "set_state": [("set_state", {"body": "box", "position": [0, 0, 2]})],
    "several": [("set_state", {"body": "box", "position": [0, 0, 2]}), ("reset_state", {})],
}


def show(recorder, messages):
    """As a node sends and logs what no step made due."""
    for name, data in messages:
        recorder.write_input(name, data)


def run(directory, operations, at, shown_before=False):
    scene = rb.load_scene("single_box")
    world = scene.build()
    with Recorder(world, directory, scene=scene, snapshot_interval=0.1) as recorder:
        recorder.perform("set_state", body="box", linear_velocity=(0.5, 0, 2))
        for step in range(300):
            if step == at:
                if shown_before:
                    show(recorder, recorder.outputs.present())
                for name, arguments in operations:
                    recorder.perform(name, **arguments)
                    show(recorder, recorder.outputs.collect(everything=True))
            world.step()
            recorder.after_step()
    return directory


@pytest.mark.parametrize("at", [150, 155])  # at an output, and between two
@pytest.mark.parametrize("kind", OPERATIONS)
def test_an_untouched_branch_does_not_part(tmp_path, kind, at):
    recording = run(tmp_path / "run", OPERATIONS[kind], at)
    assert verify(recording).difference is None
    for number, start in enumerate((0.05, at * 0.001, 0.2)):
        copy = tmp_path / f"branch_{number}"
        branch(recording, copy, start, rerun="off")
        assert compare(recording, copy).text.endswith("identical poses"), start
        assert compare(copy, recording).identical
        assert compare(copy, recording).states_part_at is None


@pytest.mark.parametrize("kind", OPERATIONS)
def test_a_state_that_one_node_showed_while_it_was_paused_is_no_difference(tmp_path, kind):
    first = run(tmp_path / "first", OPERATIONS[kind], 155)
    second = run(tmp_path / "second", OPERATIONS[kind], 155, shown_before=True)
    assert compare(first, second).identical


def test_a_reset_that_only_one_of_them_made_is_a_difference(tmp_path):
    first = run(tmp_path / "first", OPERATIONS["reset_state"], 150)
    second = run(tmp_path / "second", [], 150)
    result = compare(first, second)
    assert result.bodies[1].parts_at == 0.16
    assert result.states_part_at == pytest.approx(0.151, rel=1e-12)  # rounding of a product
