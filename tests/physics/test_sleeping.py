"""Islands at rest sleep: they cost nothing, press on as before, and wake for every reason."""

import numpy as np
import pytest

import rb_physics as rb

G = 9.81


def ground(world: rb.World, **keywords) -> rb.Body:
    return world.add_body(rb.HalfSpace((0, 0, 1), 0.0), type="static", name="ground", **keywords)


def tower(sleeping: bool = True, count: int = 4, **settings) -> rb.World:
    world = rb.World(sleeping=sleeping, **settings)
    ground(world)
    for k in range(count):
        world.add_body(
            rb.Box((0.1, 0.1, 0.1)), mass=1.0, position=(0, 0, 0.1 + 0.2 * k), name=f"box{k}"
        )
    return world


def asleep(world: rb.World) -> list[str]:
    return [body.name for body in world.bodies if body.asleep]


def test_nothing_sleeps_unless_asked_for() -> None:
    world = tower(sleeping=False)
    world.step(1500)
    assert world.stats.asleep == 0 and asleep(world) == []


def test_a_tower_sleeps_after_half_a_second_of_rest_and_costs_no_solve() -> None:
    world = tower()
    world.step(400)
    assert asleep(world) == []
    world.step(400)
    assert asleep(world) == ["box0", "box1", "box2", "box3"]
    world.step()
    assert world.stats.asleep == 4
    assert world.stats.islands == world.stats.iterations == 0
    assert world.stats.contacts == 16
    assert (world.linear_velocities == 0).all() and (world.angular_velocities == 0).all()


def test_wrenches_and_contacts_of_a_sleeping_tower_are_those_of_one_awake() -> None:
    world, twin = tower(), tower(sleeping=False)
    world.step(2000)
    twin.step(2000)
    assert len(asleep(world)) == 4
    # A tower is solved to rounding; the twin's forces differ in rounding from step to step.
    for body, other in zip(world.bodies, twin.bodies, strict=True):
        assert body.contact_wrench == pytest.approx(other.contact_wrench, abs=1e-10)
    assert world.contacts["force"] == pytest.approx(twin.contacts["force"], abs=1e-10)
    assert world["box2"].contact_wrench[0] == pytest.approx([0, 0, G], abs=1e-10)
    total = world.drain_contact_impulses()
    assert total[1, 2] == pytest.approx(2.0 * G, rel=1e-12)  # 2000 steps of 1 ms


def sleeping_tower() -> rb.World:
    world = tower()
    world.step(1000)
    assert len(asleep(world)) == 4
    return world


def test_a_wrench_wakes_and_its_end_wakes_again() -> None:
    world = sleeping_tower()
    top = world["box3"]
    top.apply_wrench((1.0, 0, 0), duration=1.5)  # friction holds it
    world.step()
    assert asleep(world) == []
    assert top.contact_wrench[0] == pytest.approx([-1, 0, G], abs=1e-10)
    world.step(1000)
    assert len(asleep(world)) == 4  # it rests again, the wrench still held
    assert top.contact_wrench[0] == pytest.approx([-1, 0, G], abs=1e-10)
    world.step(500)
    assert top.contact_wrench[0] == pytest.approx([0, 0, G], abs=1e-10)
    world.step(1000)
    assert len(asleep(world)) == 4


def test_the_same_wrench_given_again_wakes_nobody_and_another_does() -> None:
    world = tower()
    for _ in range(1200):
        world["box1"].apply_wrench((0.5, 0, 0), duration=0.1)
        world.step()
    assert len(asleep(world)) == 4
    world["box1"].apply_wrench((0.6, 0, 0), duration=0.1)
    assert not world["box1"].asleep
    world.step()
    assert asleep(world) == []
    # The end of the last message's wrench is felt.
    world.step(101)
    assert world["box0"].contact_wrench[0] == pytest.approx([0, 0, G], abs=1e-10)


def test_a_body_that_comes_along_wakes() -> None:
    world = sleeping_tower()
    ball = world.add_body(rb.Sphere(0.1), mass=1.0, position=(-1, 0, 0.7), name="ball")
    world.step(10)
    ball.position, ball.linear_velocity = (-1, 0, 0.7), (5, 0, 0)
    world.step(300)
    assert world["box3"].linear_velocity[0] != 0 or world["box3"].position[0] > 0.01


def test_clearing_pushing_setting_and_changing_wake() -> None:
    for change in (
        lambda w: w["box1"].apply_impulse((0, 0, 0.1)),
        lambda w: setattr(w["box1"], "linear_velocity", (0.1, 0, 0)),
        lambda w: setattr(w["box1"], "angular_velocity", (0, 0, 0.1)),
        lambda w: setattr(w["box1"], "position", (0.01, 0, 0.3)),
        lambda w: setattr(w["box1"], "friction", 0.1),
        lambda w: setattr(w["ground"], "friction", 0.1),
        lambda w: setattr(w["ground"], "position", (0, 0, -0.01)),
        lambda w: w.remove(w["ground"]),
        lambda w: w.remove(w["box0"]),
    ):
        world = sleeping_tower()
        change(world)
        world.step()
        assert asleep(world) == []


def test_what_loses_its_floor_falls() -> None:
    world = sleeping_tower()
    world.remove(world["ground"])
    world.step(100)
    # Free fall from rest, exact to rounding.
    assert world["box0"].position[2] == pytest.approx(0.1 - 0.5 * G * 0.1**2, abs=1e-12)


def test_less_friction_lets_a_box_slide_off_an_incline() -> None:
    angle = 0.3
    world = rb.World(gravity=(G * np.sin(angle), 0, -G * np.cos(angle)), sleeping=True)
    ground(world, friction=0.8)
    box = world.add_body(rb.Box((0.1, 0.1, 0.1)), mass=1.0, position=(0, 0, 0.1), friction=0.8)
    world.step(1000)
    assert box.asleep
    box.friction = 0.0
    world.step(1000)
    # Constant acceleration, exact to rounding.
    assert box.linear_velocity[0] == pytest.approx(G * np.sin(angle), rel=1e-9)


def test_a_kinematic_body_that_starts_to_move_wakes_what_it_carries() -> None:
    world = rb.World(sleeping=True)
    tray = world.add_body(rb.Box((0.5, 0.5, 0.1)), type="kinematic", position=(0, 0, 0.5))
    box = world.add_body(rb.Box((0.1, 0.1, 0.1)), mass=1.0, position=(0, 0, 0.7))
    world.step(1000)
    assert box.asleep
    tray.linear_velocity = (0, 0, 0.2)
    world.step(500)
    assert not box.asleep
    # Both rise by 0.1 m.
    assert box.position[2] - tray.position[2] == pytest.approx(0.2, abs=1e-8)
    tray.linear_velocity = (0, 0, 0)
    world.step(1000)
    assert box.asleep
    tray.move(tray.position + [0.01, 0, 0], (0, 0, 0, 1))
    world.step()
    assert not box.asleep
    assert box.contact_wrench[0, 0] > 0  # friction drags it along


def test_slow_motion_is_not_stopped() -> None:
    world = rb.World(gravity=(0, 0, 0), sleeping=True)
    body = world.add_body(rb.Sphere(0.1), mass=1.0, linear_velocity=(1e-5, 0, 0))
    world.step(3000)
    assert not body.asleep
    assert body.position[0] == pytest.approx(3e-5, rel=1e-12)


@pytest.mark.parametrize("when", [300, 900])
def test_a_snapshot_holds_who_sleeps_and_how_long_it_rests(when: int) -> None:
    world, twin = tower(), tower()
    world.step(when)
    twin.restore(world.save())
    assert twin.state_hash == world.state_hash
    for _ in range(3):
        world.step(200)
        twin.step(200)
        assert twin.state_hash == world.state_hash
    world["box2"].apply_wrench((0.1, 0, 0))
    twin["box2"].apply_wrench((0.1, 0, 0))
    world.step(5)
    twin.step(5)
    assert twin.state_hash == world.state_hash


def test_sleepers_have_the_same_bits_for_any_number_of_threads() -> None:
    def run(threads: int) -> list[int]:
        world = rb.World(sleeping=True, threads=threads, dt=2e-3)
        ground(world)
        for k in range(60):
            drop = 0.1 if k % 2 else 0.2
            world.add_body(rb.Box((0.1, 0.1, 0.1)), mass=1.0, position=(0.5 * k, 0, drop))
        found = []
        for k in range(60):
            world.step(10)
            found.append(world.state_hash)
            if k == 50:
                world.bodies[7].apply_wrench((1, 0, 0))
        assert world.stats.asleep > 30
        return found

    assert run(1) == run(2) == run(4)
