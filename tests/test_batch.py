"""A batch is its variations, each to the bit as if alone."""

import numpy as np
import pytest

import rb_physics as rb


def scene(**settings) -> rb.World:
    world = rb.World(dt=2e-3, **settings)
    world.add_body(rb.HalfSpace((0, 0, 1), 0.0), type="static", name="ground", restitution=0.3)
    world.add_body(rb.Box((0.1, 0.1, 0.1)), mass=1.0, position=(0, 0, 0.3), name="box")
    world.add_body(
        rb.Sphere(0.1), mass=0.5, position=(0.1, 0, 0.6), name="ball", rolling_friction=0.01
    )
    world.add_body(
        rb.Box((0.5, 0.1, 0.1)),
        type="kinematic",
        position=(0.9, 0, 0.2),
        angular_velocity=(0, 0, 1.0),
        name="arm",
        frames={"tip": ((0.5, 0, 0), (0, 0, 0, 1))},
    )
    return world


def vary(world: rb.World, i: int) -> None:
    world["box"].friction = 0.1 * (i + 1)
    world["ball"].linear_velocity = (0.3 * i, 0.1, 0)
    world["box"].apply_wrench((0.2 * i, 0, 0), duration=0.05)


@pytest.mark.parametrize("threads", [1, 2, 4])
def test_every_variation_has_the_bits_of_a_world_stepped_alone(threads: int) -> None:
    start = scene()
    start.step(40)
    batch = rb.Batch(start, 6, threads=threads)
    for i, variation in enumerate(batch):
        vary(variation, i)
    batch.step(150)
    for i in range(6):
        alone = scene()
        alone.step(40)
        vary(alone, i)
        alone.step(150)
        assert batch.state_hashes[i] == alone.state_hash == batch[i].state_hash
        assert (batch.positions[i] == alone.positions).all()
        assert (batch.contact_wrenches[i] == alone.contact_wrenches).all()
    assert len(set(batch.state_hashes.tolist())) == 6
    assert start.step_count == 40  # the original stays as it is


def test_arrays_have_a_row_per_variation_and_body() -> None:
    batch = rb.Batch(scene(), 3)
    assert len(batch) == 3
    assert batch.positions.shape == (3, 4, 3)
    assert batch.orientations.shape == (3, 4, 4)
    assert batch.linear_velocities.shape == batch.angular_velocities.shape == (3, 4, 3)
    assert batch.contact_wrenches.shape == (3, 4, 2, 3)
    assert batch.state_hashes.shape == (3,)


def test_arrays_set_all_variations_at_once() -> None:
    batch, twin = rb.Batch(scene(), 3), rb.Batch(scene(), 3)
    random = np.random.default_rng(0)
    x = batch.positions + [0, 0, 1] + random.uniform(0, 0.1, (3, 4, 3)) * [[0], [1], [1], [0]]
    x[:, 0] = 0
    q = random.normal(size=(3, 4, 4))
    q /= np.linalg.norm(q, axis=-1, keepdims=True)
    q[:, 0] = (0, 0, 0, 1)
    v, w = random.normal(size=(2, 3, 4, 3))
    v[:, 0] = w[:, 0] = 0
    batch.positions, batch.orientations = x, q
    batch.linear_velocities, batch.angular_velocities = v, w
    for i, world in enumerate(twin):
        for body in world.bodies:
            body.position, body.orientation = x[i, body.row], q[i, body.row]
            if body.type != "static":
                body.linear_velocity, body.angular_velocity = v[i, body.row], w[i, body.row]
    # Rounding of a product and a quotient with the mass or the inertia.
    assert batch.linear_velocities == pytest.approx(v, abs=1e-14)
    assert batch.angular_velocities == pytest.approx(w, abs=1e-13)
    assert (batch.state_hashes == twin.state_hashes).all()
    batch.step(50)
    twin.step(50)
    assert (batch.state_hashes == twin.state_hashes).all()


@pytest.mark.parametrize("duration", [None, 0, 0.01])
def test_wrenches_act_on_each_body_of_each_variation(duration: float | None) -> None:
    batch, twin = rb.Batch(scene(), 3), rb.Batch(scene(), 3)
    random = np.random.default_rng(0)
    force, torque = random.normal(size=(2, 3, 4, 3))
    batch.apply_wrenches(force, torque, duration=duration)
    for i, world in enumerate(twin):
        for name in ("box", "ball"):
            body = world[name]
            body.apply_wrench(force[i, body.row], torque[i, body.row], duration=duration)
    batch.step(20)
    twin.step(20)
    assert (batch.state_hashes == twin.state_hashes).all()


def test_copy_goes_on_with_the_same_bits_and_is_independent() -> None:
    world = scene()
    world.step(120)
    twin = world.copy()
    assert twin["arm"].frames.keys() == {"tip"}
    assert [body.name for body in twin.bodies] == [body.name for body in world.bodies]
    world.step(100)
    assert twin.step_count == 120
    twin.step(100)
    assert twin.state_hash == world.state_hash
    twin["box"].position = (0, 0, 5)
    assert world["box"].position[2] < 1


def test_one_variation_that_diverges_is_named_and_stops_no_other() -> None:
    batch, alone = rb.Batch(scene(), 3, threads=2), scene()
    batch[1]["box"].apply_impulse((1e121, 0, 0))
    with pytest.raises(rb.DivergedError, match="variation 1, step 0") as caught:
        batch.step()
    alone.step()
    assert caught.value.variation == 1
    assert batch.state_hashes[0] == batch.state_hashes[2] == alone.state_hash
    assert np.isfinite(batch.positions).all()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [({"n": 0}, "n is 0"), ({"n": 2.0}, "n is 2.0"), ({"n": 1, "threads": 0}, "threads is 0")],
)
def test_bad_sizes_are_refused(arguments: dict, words: str) -> None:
    with pytest.raises(rb.SceneError, match=words):
        rb.Batch(scene(), **arguments)


def test_bad_arrays_are_refused() -> None:
    batch = rb.Batch(scene(), 2)
    before = batch.state_hashes
    with pytest.raises(rb.SceneError, match=r"positions.*shape \(2, 4, 3\)"):
        batch.positions = np.zeros((2, 3, 3))
    with pytest.raises(rb.SceneError, match="finite"):
        batch.linear_velocities = np.full((2, 4, 3), np.nan)
    with pytest.raises(rb.SceneError, match="unit quaternions"):
        batch.orientations = np.ones((2, 4, 4))
    with pytest.raises(rb.SceneError, match="torques"):
        batch.apply_wrenches(np.zeros((2, 4, 3)), np.zeros((2, 4, 2)))
    with pytest.raises(rb.SceneError, match="duration"):
        batch.apply_wrenches(np.zeros((2, 4, 3)), duration=-1)
    assert (batch.state_hashes == before).all()
    batch[0].remove(batch[0]["ball"])
    with pytest.raises(rb.SceneError, match="different numbers of bodies"):
        batch.positions  # noqa: B018
