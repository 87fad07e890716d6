"""What the Python face takes and how it answers: numbers and arrays of every layout, attributes, huge
values."""

import numpy as np
import pytest

import rb_physics as rb

UP, AT_REST = (0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 1.0)


def new_world():
    world = rb.World()
    world.add_body(rb.HalfSpace(normal=UP, offset=0.0), type="static", name="ground")
    world.add_body(rb.Sphere(0.1), mass=1.0, position=(0, 0, 0.1), name="ball")
    world.add_body(rb.Box((0.1, 0.1, 0.1)), type="kinematic", position=(3, 0, 0), name="robot")
    world.step()
    return world


# Numbers and arrays of every kind that hold what is asked for.
GOOD_NUMBERS = [2, 2.0, np.float32(2), np.float64(2), np.int8(2), np.array(2.0), np.array(2)]


@pytest.mark.parametrize("two", GOOD_NUMBERS, ids=lambda v: f"{type(v).__name__} {v!r}")
def test_numpy_scalars_are_numbers(two):
    world = new_world()
    ball = world["ball"]
    ball.friction = two
    assert ball.friction == 2.0 and type(ball.friction) is float
    crate = world.add_body(rb.Sphere(two), mass=two, position=(9, 0, 0))
    assert crate.mass == 2.0 and crate.shape == rb.Sphere(2.0)
    assert rb.Settings(dt=two).dt == 2.0 and type(rb.Settings(dt=two).dt) is float
    ball.apply_wrench((0, 0, 1), duration=two)
    assert rb.math.cos(two) == rb.math.cos(2.0)


@pytest.mark.parametrize("count", [2, np.int64(2), np.uint8(2), np.array(2)])
def test_whole_numbers_of_numpy_count(count):
    world = new_world()
    world.step(count)
    assert world.step_count == 3
    assert rb.Settings(threads=count).threads == 2
    assert len(rb.Batch(world, count)) == 2


READ_ONLY = np.array([1.0, 2.0, 3.0])
READ_ONLY.flags.writeable = False
GOOD_VECTORS = [
    [1, 2, 3], (1.0, 2.0, 3.0), range(1, 4), np.array([1, 2, 3]), np.array([1, 2, 3], np.float32),
    np.array([1, 2, 3], np.uint8), np.arange(1.0, 7.0, 1.0).reshape(3, 2).T.copy().T[:, 0] * 0 + [1, 2, 3],
    np.array([1.0, 9.0, 2.0, 9.0, 3.0])[::2], np.array([1, 2, 3], ">f8"), READ_ONLY,
    np.array([1, 2, 3], object),
]  # fmt: skip


@pytest.mark.parametrize("vector", GOOD_VECTORS, ids=lambda v: f"{type(v).__name__} {v!r}"[:50])
def test_vectors_of_any_layout(vector):
    world = new_world()
    world["ball"].position = vector
    assert world["ball"].position.tolist() == [1.0, 2.0, 3.0]
    assert rb.Box(vector) == rb.Box((1, 2, 3))
    assert (rb.math.skew(vector) == rb.math.skew((1.0, 2.0, 3.0))).all()
    assert rb.World(gravity=vector).settings.gravity == (1.0, 2.0, 3.0)


def test_what_would_be_lost_is_refused_with_a_suggestion():
    world = new_world()
    ball, batch = world["ball"], rb.Batch(world, 2)
    for owner, name, words in (
        (ball, "postion", "did you mean 'position'"),
        (ball, "name", "Body.name can't be set"),
        (ball, "type", "Body.type can't be set"),
        (ball, "mass", "remove the body and add another"),
        (ball, "move", "Body.move is a method; call it"),
        (world, "gravty", "did you mean 'gravity'"),
        (world, "gravity", "World.gravity can't be set: settings hold for life"),
        (world, "settings", "World.settings can't be set"),
        (world, "positions", "state is set through the bodies"),
        (batch, "position", "did you mean 'positions'"),
        (batch, "contact_wrenches", "Batch.contact_wrenches can't be set"),
        (rb.Settings(), "dtt", "did you mean 'dt'"),
        (rb.Settings(), "dt", "rb.World(settings, dt=...)"),
    ):
        with pytest.raises(AttributeError) as caught:
            setattr(owner, name, 1)
        assert words in str(caught.value)
    assert not hasattr(ball, "__dict__") and not hasattr(world, "__dict__")


def test_arrays_of_the_state_are_not_to_be_written_to():
    world = new_world()
    ball, batch = world["ball"], rb.Batch(world, 2)
    arrays = [
        getattr(ball, name)
        for name in ("position", "orientation", "com_position", "linear_velocity",
                     "angular_velocity", "center_of_mass", "inertia")
    ] + [
        getattr(owner, name)
        for owner in (world, batch)
        for name in ("positions", "orientations", "linear_velocities", "angular_velocities")
    ] + [world.com_positions, world.gravity]  # fmt: skip
    for array in arrays:
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0.0
    ball.position = ball.position + (0, 0, 1)  # what to do instead
    assert ball.position[2] == world.positions[ball.row, 2] > 1.0
    with pytest.raises(TypeError):
        ball.frames["tip"] = (UP, AT_REST)


def test_both_coefficients_of_friction_set_at_once():
    ball = new_world()["ball"]
    ball.set_material(friction=0.3, static_friction=0.6)
    assert (ball.friction, ball.static_friction) == (0.3, 0.6)
    ball.set_material(friction=0.6)
    ball.friction = 0.2  # equal before: the static one follows
    assert ball.static_friction == 0.2


def test_bodies_in_a_world():
    world, other = new_world(), new_world()
    assert "ball" in world and world["ball"] in world
    assert world["ball"] not in other and "box" not in world and [] not in world
    with pytest.raises(KeyError, match=r"no body is named 0; .*world.bodies\[row\]"):
        world[0]
    with pytest.raises(KeyError, match="no body is named"):
        world[[]]


HUGE = [10.0**e for e in (20, 28, 31, 60, 120, 155, 200, 307)]
PUSHES = {
    "force": lambda w, m: w["ball"].apply_wrench((m, 0, -m)),
    "torque": lambda w, m: w["ball"].apply_wrench(torque=(m, 0, m)),
    "impulse": lambda w, m: w["ball"].apply_impulse((m, 0, -m)),
    "impulse far away": lambda w, m: w["ball"].apply_impulse((m, 0, 0), (0, m, 0)),
    "position": lambda w, m: setattr(w["ball"], "position", (0, 0, -m)),
    "velocity": lambda w, m: setattr(w["ball"], "linear_velocity", (m, m, -m)),
    "turning": lambda w, m: setattr(w["ball"], "angular_velocity", (m, m, m)),
    "robot's target": lambda w, m: w["robot"].move(position=(-m, 0, 0)),
    "robot's velocity": lambda w, m: w["robot"].move(linear_velocity=(-m, 0, 0)),
    "robot's turning": lambda w, m: w["robot"].move(angular_velocity=(m, m, 0)),
    "friction": lambda w, m: setattr(w["ball"], "friction", m),
    "mass": lambda w, m: w.add_body(rb.Sphere(1), mass=m, position=(0, 0, 2)),
    "small mass": lambda w, m: w.add_body(rb.Sphere(1), mass=1 / m, position=(0, 0, 2)),
    "center of mass": lambda w, m: w.add_body(rb.Sphere(1), mass=1, center_of_mass=(m, 0, 0)),
}


@pytest.mark.timeout(60)
@pytest.mark.parametrize("size", HUGE)
@pytest.mark.parametrize("push", PUSHES)
def test_huge_numbers_end_in_a_clear_error_or_a_finite_state(push, size):
    world = new_world()
    try:
        PUSHES[push](world, size)
        world.step(3)
    except rb.SceneError:
        pass
    except rb.DivergedError as error:
        assert error.body in world
    for array in (world.positions, world.orientations, world.linear_velocities,
                  world.angular_velocities, world.contact_wrenches):  # fmt: skip
        assert np.isfinite(array).all()


@pytest.mark.parametrize("settings", [{"dt": 1e200}, {"gravity": (0, 0, -1e200)}])
def test_huge_settings_diverge_with_a_name(settings):
    world = rb.World(**settings)
    world.add_body(rb.HalfSpace(normal=UP, offset=0.0), type="static", name="ground")
    world.add_body(rb.Sphere(1), mass=1.0, position=(0, 0, 3), name="ball")
    with pytest.raises(rb.DivergedError, match="ball"):
        world.step(3)
    assert world["ball"].position.tolist() == [0.0, 0.0, 3.0]


@pytest.mark.parametrize("length", [5e-324, 1e-200, 1e-3, 1e200, 1.7e308])
def test_the_direction_of_a_ray_may_have_any_length(length):
    hit = new_world().ray_cast((0, 0, 1), (0, 0, -length))
    # The top of the ball, 0.8 m down; rounding of a step of rest.
    assert hit.body.name == "ball" and hit.distance == pytest.approx(0.8, abs=1e-12)
