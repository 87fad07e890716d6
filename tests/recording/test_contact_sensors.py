"""Contact wrenches per pair of bodies, and in any frame about any reference point."""

import numpy as np
import pytest

import rb_physics as rb
from rb_physics.recording.decoders import decode_wrench_stamped
from rb_physics.recording.outputs import Outputs
from rb_physics.recording.topics import TopicError, parse_topics

WRENCH = "type: geometry_msgs/msg/WrenchStamped, direction: out, rate: 100"


def world_of_a_grip():
    """A 2 kg cup on a table, leant on by two fingers from the sides; g = 10 m/s²."""
    world = rb.World(gravity=(0, 0, -10), dt=1e-3)
    half = (0.05, 0.05, 0.1)
    world.add_body(rb.Box((1, 1, 0.1)), type="static", name="table", position=(0, 0, -0.1))
    world.add_body(rb.Box(half), mass=2.0, name="cup", position=(0, 0, 0.1), frames={
        "rim": ((0.0, 0.0, 0.1), (0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5)))})  # fmt: skip
    for name, side in (("left", -1), ("right", 1)):
        finger = world.add_body(
            rb.Box((0.02, 0.02, 0.02)),
            mass=0.1,
            name=name,
            position=(0.07 * side, 0, 0.15),
            friction=1.0,
        )
        finger.apply_wrench(force=(-6.0 * side, 0, 1.0))  # presses, and carries its own weight
    return world


def outputs_of(world, *entries):
    return Outputs(world, parse_topics("topics:\n" + "\n".join(f"  - {{{e}}}" for e in entries)))


def read(messages, name):
    message = decode_wrench_stamped(dict(messages)["/sim_node/" + name])
    return np.array(message.values[:3]), np.array(message.values[3:]), message.frame_id


def test_each_pair_carries_its_own_wrench_and_together_they_are_the_whole():
    world = world_of_a_grip()
    outputs = outputs_of(
        world,
        f"name: ~/bodies/NAME/contact_wrench, content: contact_wrench, {WRENCH}, bodies: [cup], frame: world",
        f"name: ~/bodies/NAME/contact_wrench/OTHER, content: pair_wrench, {WRENCH}, bodies: [cup, table], "
        "others: [left, right, table, cup], frame: world",
    )
    for _ in range(40):
        world.step(10)
        messages = outputs.collect()
    left, torque_left, _ = read(messages, "bodies/cup/contact_wrench/left")
    right, _, _ = read(messages, "bodies/cup/contact_wrench/right")
    table, _, _ = read(messages, "bodies/cup/contact_wrench/table")
    # At rest: 6 N from each side, the weight from below. 1e-9: the solver's residual times some N
    np.testing.assert_allclose(left, (6, 0, 0), atol=1e-9)
    np.testing.assert_allclose(right, (-6, 0, 0), atol=1e-9)
    np.testing.assert_allclose(table, (0, 0, 20), atol=1e-9)
    np.testing.assert_allclose(torque_left, (0, 6 * 0.05, 0), atol=1e-9)  # 50 mm above the centre
    on_table, _, frame = read(messages, "bodies/table/contact_wrench/cup")
    np.testing.assert_allclose(on_table, (0, 0, -20), atol=1e-9)
    assert frame == "world"
    whole, _, _ = read(messages, "bodies/cup/contact_wrench")
    np.testing.assert_allclose(whole, left + right + table, atol=1e-12)


def test_axes_and_reference_point_are_those_asked_for():
    world = world_of_a_grip()
    outputs = outputs_of(
        world,
        f"name: ~/bodies/NAME/rim, content: contact_wrench, {WRENCH}, bodies: [cup], frame: NAME/rim",
        f"name: ~/bodies/NAME/seen, content: contact_wrench, {WRENCH}, bodies: [left], frame: cup/rim, "
        "reference_point: world",
        f"name: ~/bodies/NAME/plate, content: contact_wrench, {WRENCH}, bodies: [table], frame: world, "
        "reference_point: cup",
    )
    for _ in range(40):
        world.step(10)
        messages = outputs.collect()
    force, torque, frame = read(messages, "bodies/cup/rim")
    assert frame == "cup/rim"
    np.testing.assert_allclose(force, (0, 0, 20), atol=1e-9)
    np.testing.assert_allclose(torque, 0, atol=1e-9)
    force, torque, frame = read(messages, "bodies/left/seen")
    assert frame == "cup/rim"
    # The cup pushes the left finger with -6 N along x, at z = 0.15 m: torque -0.9 N m about y of the
    # world; the rim's axes are a quarter turn about z: x_rim = y, y_rim = -x.
    np.testing.assert_allclose(force, (0, 6, 0), atol=1e-9)
    np.testing.assert_allclose(torque, (-0.9, 0, 0), atol=1e-9)
    force, torque, _ = read(messages, "bodies/table/plate")
    np.testing.assert_allclose(force, (0, 0, -20), atol=1e-9)
    np.testing.assert_allclose(torque, 0, atol=1e-9)  # straight below the cup


def test_no_impulse_of_a_pair_is_lost_when_bodies_come_and_go_in_between():
    world = rb.World(gravity=(0, 0, -10), dt=1e-3)
    world.add_body(rb.HalfSpace((0, 0, 1), 0), type="static", name="ground")
    world.add_body(rb.Sphere(0.1), mass=9.0, name="bystander", position=(5, 0, 0.1))
    ball = world.add_body(
        rb.Sphere(0.1), mass=1.0, name="ball", position=(0, 0, 0.4), restitution=0.8
    )
    outputs = outputs_of(
        world,
        f"name: ~/bodies/NAME/contact_wrench, content: contact_wrench, {WRENCH}, bodies: [ball], frame: world",
        f"name: ~/bodies/NAME/contact_wrench/OTHER, content: pair_wrench, {WRENCH}, bodies: [ball], "
        "others: all, frame: world",
    )
    total = {"contact_wrench": 0.0, "contact_wrench/ground": 0.0}
    last = 0.0
    for step in range(1, 1001):
        world.step()
        if step == 233:
            world.remove(world["bystander"])
            outputs.rebuild()
        if step == 377:
            world.add_body(rb.Sphere(0.1), mass=1.0, name="late", position=(0, 3, 0.1))
            outputs.rebuild()
        messages = dict(outputs.collect())
        if "/sim_node/bodies/ball/contact_wrench" in messages:
            for name in total:
                total[name] += read(messages.items(), f"bodies/ball/{name}")[0][2] * (
                    world.time - last
                )
            last = world.time
    gained = 1.0 * ball.linear_velocity[2] + 10.0 * world.time
    assert gained > 5.0  # it bounced
    for impulse in total.values():
        assert impulse == pytest.approx(gained, rel=1e-12)  # sums of 100 numbers


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        (f"name: ~/bodies/NAME/x, content: contact_wrench, {WRENCH}, frame: NAME/nose", "there is no frame 'cup/nose'"),
        (f"name: ~/bodies/NAME/x, content: contact_wrench, {WRENCH}, reference_point: mars/com", "no frame 'mars/com'"),
        (f"name: ~/bodies/NAME/x, content: contact_wrench, {WRENCH}, frame: 'a b'", "frame: 'a b'"),
        (f"name: ~/bodies/NAME/x, content: pair_wrench, {WRENCH}", "needs a part OTHER"),
        (f"name: ~/bodies/NAME/OTHER, content: contact_wrench, {WRENCH}", "can't hold OTHER"),
        (f"name: ~/bodies/NAME/OTHER, content: pair_wrench, {WRENCH}, others: [nobody]", "there is no body 'nobody'"),
        (f"name: ~/bodies/NAME/x, content: contact_wrench, {WRENCH}, others: [cup]", "others: contact_wrench has none"),
    ],
)  # fmt: skip
def test_errors_name_line_and_field(entry, words):
    with pytest.raises(TopicError, match=r"topics.yaml:2: ") as error:
        outputs_of(world_of_a_grip(), entry.replace("rate: 100", "rate: 100, bodies: [cup]"))
    assert words in str(error.value)
