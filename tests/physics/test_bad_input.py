"""Bad input raises SceneError that names the body, the field, the value and what is allowed."""

import math

import numpy as np
import pytest

import rb_physics as rb

NAN, INF = math.nan, math.inf


def new_world(**settings):
    world = rb.World(**settings)
    world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", name="ground")
    world.add_body(rb.Sphere(0.1), mass=1.0, position=(0, 0, 1), name="ball")
    world.add_body(rb.Box((0.1, 0.1, 0.1)), type="kinematic", position=(3, 0, 0), name="robot")
    return world


def refused(words, call, *arguments, **keywords):
    """The call raises a SceneError whose message holds all the words; returns it."""
    with pytest.raises(rb.SceneError) as caught:
        call(*arguments, **keywords)
    message = str(caught.value)
    assert isinstance(caught.value, ValueError)
    missing = [w for w in words if w not in message]
    assert not missing, f"{missing} not in {message!r}"
    assert "\n" not in message
    return caught.value


# field, value -> words the message must hold besides body, field
BAD_BODIES = [
    ({"mass": 0.0}, "> 0 (kg)"),
    ({"mass": -1.0}, "-1.0"),
    ({"mass": NAN}, "nan"),
    ({"mass": INF}, "inf"),
    ({"mass": "heavy"}, "'heavy'"),
    ({"mass": True}, "True"),
    ({"density": 0.0}, "> 0 (kg/m³)"),
    ({"density": -5.0}, "-5.0"),
    ({"position": (0, 0)}, "3 finite numbers"),
    ({"position": (0, NAN, 0)}, "3 finite numbers"),
    ({"position": (0, INF, 0)}, "3 finite numbers"),
    ({"position": "here"}, "3 finite numbers"),
    ({"position": None}, "3 finite numbers"),
    ({"orientation": (0, 0, 0, 0)}, "unit quaternion x y z w"),
    ({"orientation": (1, 0, 0, 1)}, "its length is 1.41421"),
    ({"orientation": (0, 0, 1)}, "4 finite numbers"),
    ({"orientation": (0, 0, 0, NAN)}, "4 finite numbers"),
    ({"linear_velocity": (0, 0, NAN)}, "3 finite numbers (m/s)"),
    ({"angular_velocity": (INF, 0, 0)}, "3 finite numbers (rad/s)"),
    ({"inertia": (1, 2)}, "3 principal moments or a 3 x 3 matrix"),
    ({"inertia": (1, 1, NAN)}, "3 principal moments"),
    ({"inertia": (1, 1, -1)}, "positive definite"),
    ({"inertia": (1, 1, 0)}, "positive definite"),
    ({"inertia": (1, 1, 3)}, "may not exceed the sum of the other two"),
    ({"inertia": [[1, 0.1, 0], [0, 1, 0], [0, 0, 1]]}, "symmetric"),
    ({"center_of_mass": (0, 0)}, "3 finite numbers"),
    ({"friction": -0.1}, "≥ 0"),
    ({"friction": NAN}, "nan"),
    ({"restitution": 1.5}, "≤ 1"),
    ({"restitution": -0.1}, "≥ 0"),
    ({"static_friction": 0.1}, "≥ friction (0.5)"),
    ({"rolling_friction": -1.0}, "≥ 0"),
    ({"spinning_friction": INF}, "finite"),
    ({"frames": {"tip": ((0, 0), (0, 0, 0, 1))}}, "3 finite numbers"),
    ({"frames": {"tip": ((0, 0, 0), (0, 0, 0, 2))}}, "unit quaternion"),
    ({"frames": {"tip": 3}}, "(position, orientation)"),
]


@pytest.mark.parametrize(("bad", "words"), BAD_BODIES, ids=lambda v: str(v)[:40])
def test_body_fields(bad, words):
    world = new_world()
    before, hash_before = len(world), world.state_hash
    keywords = {"mass": 1.0, **bad} if "density" not in bad else bad
    field = next(iter(bad))
    error = refused(
        ["crate", field, words], world.add_body, rb.Box((1, 1, 1)), name="crate", **keywords
    )
    assert error.body == "crate"
    assert error.field.startswith(field)
    # Nothing was added by halves.
    assert len(world) == before and "crate" not in world and world.state_hash == hash_before
    world.step()


def test_exactly_one_of_mass_and_density():
    world = new_world()
    refused(["crate", "neither", "exactly one"], world.add_body, rb.Box((1, 1, 1)), name="crate")
    refused(
        ["crate", "both", "exactly one"],
        world.add_body,
        rb.Box((1, 1, 1)),
        mass=1.0,
        density=1.0,
        name="crate",
    )


@pytest.mark.parametrize(
    "name", ["", "1st", "a b", "ä", "world", "a/b", "a-b", "_x", 3, "a\n", "com!"]
)
def test_names_become_topics(name):
    error = refused(
        [repr(name), "a letter followed by letters, digits and underscores"],
        new_world().add_body,
        rb.Sphere(1),
        mass=1.0,
        name=name,
    )
    assert error.field == "body name"


def test_names_are_unique():
    refused(["'ball'", "already taken"], new_world().add_body, rb.Sphere(1), mass=1.0, name="ball")


def test_frame_names():
    world = new_world()
    pose = ((0, 0, 0), (0, 0, 0, 1))
    for name in ("com", "world", "1"):
        refused([name], world.add_body, rb.Sphere(1), mass=1.0, frames={name: pose})


@pytest.mark.parametrize("kind", ["floating", None, 3])
def test_types(kind):
    refused(
        ["type", repr(kind), "'dynamic', 'static' or 'kinematic'"],
        new_world().add_body,
        rb.Sphere(1),
        mass=1.0,
        type=kind,
    )


def test_what_is_no_shape():
    refused(["shape", "'ball'", "Sphere"], new_world().add_body, "ball", mass=1.0)


def test_half_space_must_be_static_or_kinematic():
    refused(
        ["'static'", "half_space"],
        new_world().add_body,
        rb.HalfSpace(normal=(0, 0, 1), offset=0.0),
        mass=1.0,
    )


def test_static_bodies_do_not_move():
    world = new_world()
    for field in ("linear_velocity", "angular_velocity"):
        refused(
            ["wall", "static", field],
            world.add_body,
            rb.Sphere(1),
            type="static",
            name="wall",
            **{field: (1, 0, 0)},
        )
        with pytest.raises(rb.SceneError, match=f"'ground' is static; {field}"):
            setattr(world["ground"], field, (1, 0, 0))


def test_particles_have_no_rotation_and_no_volume():
    world = new_world()
    for keywords, words in (
        ({"mass": 1.0, "angular_velocity": (1, 0, 0)}, ["does not rotate"]),
        ({"density": 1.0}, ["density", "no volume"]),
        ({"mass": 1.0, "inertia": (1, 1, 1)}, ["inertia"]),
        ({"mass": 1.0, "center_of_mass": (1, 0, 0)}, ["center_of_mass"]),
        ({"type": "static"}, ["surface"]),
    ):
        refused(["dust", *words], world.add_body, rb.Particle(), name="dust", **keywords)


BAD_SHAPES = [
    (rb.Sphere, (0.0,), "radius"),
    (rb.Sphere, (-1.0,), "radius"),
    (rb.Sphere, (NAN,), "radius"),
    (rb.Box, ((1, 1),), "half_extents"),
    (rb.Box, ((1, 0, 1),), "half_extents"),
    (rb.Box, ((1, INF, 1),), "half_extents"),
    (rb.Capsule, (0.0, 1.0), "radius"),
    (rb.Capsule, (1.0, -1.0), "half_length"),
    (rb.Cylinder, (1.0, 0.0), "half_length"),
    (rb.Cylinder, (NAN, 1.0), "radius"),
    (rb.HalfSpace, ((0, 0, 0), 0.0), "normal"),
    (rb.HalfSpace, ((0, 0, NAN), 0.0), "normal"),
    (rb.HalfSpace, ("up", 0.0), "normal"),
    (rb.HalfSpace, ((0, 0, 1), INF), "offset"),
    (rb.Compound, ([],), "part"),
]


@pytest.mark.parametrize(("shape", "arguments", "field"), BAD_SHAPES, ids=lambda v: str(v)[:30])
def test_shapes(shape, arguments, field):
    refused([field], shape, *arguments)


@pytest.mark.parametrize(
    "points",
    [
        [(0, 0, 0), (1, 0, 0), (0, 1, 0)],  # too few
        [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)],  # flat
        [(0, 0, 0)] * 8,  # one point
        [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, NAN)],
    ],
)
def test_hulls_without_volume(points):
    if not hasattr(rb, "ConvexHull"):
        pytest.xfail("convex hulls are not in the public face yet")
    refused(["hull"], rb.ConvexHull, points)


BAD_SETTINGS = [
    ({"dt": 0.0}, "dt", "> 0"),
    ({"dt": -1e-3}, "dt", "> 0"),
    ({"dt": NAN}, "dt", "finite"),
    ({"dt": "1"}, "dt", "'1'"),
    ({"gravity": (0, 0)}, "gravity", "three finite numbers"),
    ({"gravity": (0, 0, INF)}, "gravity", "three finite numbers"),
    ({"gravity": 9.81}, "gravity", "three finite numbers"),
    ({"stepper": "variable"}, "stepper", "'fixed'"),
    ({"impact_law": "newton"}, "impact_law", "'reflections'"),
    ({"free_motion": "euler"}, "free_motion", "'exact'"),
    ({"threads": 0}, "threads", "≥ 1"),
    ({"threads": 1.5}, "threads", "whole number"),
    ({"sleeping": 1}, "sleeping", "True or False"),
    ({"tolerance": 0}, "tolerance", "between 0 and 1"),
    ({"tolerance": 2}, "tolerance", "between 0 and 1"),
    ({"max_work": -1}, "max_work", "≥ 0"),
    ({"contact_margin": -1}, "contact_margin", "≥ 0"),
    ({"restitution_threshold": -1}, "restitution_threshold", "≥ 0"),
    ({"friction_combine": "sum"}, "friction_combine", "'geometric_mean'"),
    ({"restitution_combine": "sum"}, "restitution_combine", "'max'"),
    ({"graviti": (0, 0, 0)}, "graviti", "did you mean 'gravity'"),
    ({"colour": 3}, "colour", "known are"),
]


@pytest.mark.parametrize(("bad", "field", "words"), BAD_SETTINGS, ids=lambda v: str(v)[:40])
def test_settings(bad, field, words):
    error = refused([field, words], rb.World, **bad)
    assert error.field == field
    if field in rb.Settings.__dataclass_fields__:
        refused([field, words], rb.Settings, **bad)


SETTABLE = [
    ("position", (0, 0, NAN), "3 finite numbers"),
    ("position", (1, 2), "3 finite numbers"),
    ("orientation", (0, 0, 0, 2), "unit quaternion"),
    ("com_position", (INF, 0, 0), "3 finite numbers"),
    ("linear_velocity", (NAN, 0, 0), "3 finite numbers"),
    ("angular_velocity", "fast", "3 finite numbers"),
    ("friction", -1, "≥ 0"),
    ("restitution", 2, "≤ 1"),
    ("static_friction", 0.1, "≥ friction"),
    ("rolling_friction", NAN, "finite"),
]


@pytest.mark.parametrize(("field", "value", "words"), SETTABLE)
def test_setting_a_field(field, value, words):
    world = new_world()
    ball = world["ball"]
    before = world.state_hash
    old = np.array(getattr(ball, field))
    refused(["ball", field, words], setattr, ball, field, value)
    np.testing.assert_array_equal(getattr(ball, field), old)
    assert world.state_hash == before


BAD_WRENCHES = [
    ({"force": (0, 0)}, "force"),
    ({"force": (0, 0, NAN)}, "force"),
    ({"torque": (INF, 0, 0)}, "torque"),
    ({"point": (0, NAN, 0)}, "point"),
    ({"frame": "ball"}, "'world' or 'body'"),
    ({"frame": ""}, "'world' or 'body'"),
    ({"duration": -0.1}, "duration"),
    ({"duration": NAN}, "duration"),
]


@pytest.mark.parametrize(("bad", "words"), BAD_WRENCHES, ids=lambda v: str(v)[:40])
def test_applied_wrenches(bad, words):
    world = new_world()
    before = world.state_hash
    refused(["ball", words], world["ball"].apply_wrench, **bad)
    assert world.state_hash == before


def test_wrenches_and_impulses_need_a_dynamic_body():
    world = new_world()
    for name in ("ground", "robot"):
        for method in ("apply_wrench", "apply_impulse"):
            refused([name, method, "needs a dynamic body"], getattr(world[name], method), (0, 0, 1))
    refused(["ball", "impulse"], world["ball"].apply_impulse, (0, 0, NAN))
    refused(["ball", "point"], world["ball"].apply_impulse, (0, 0, 1), (0, 0))


def test_only_kinematic_bodies_are_moved():
    world = new_world()
    refused(["ball", "dynamic", "only kinematic"], world["ball"].move, (0, 0, 0))
    refused(["ground", "static", "only kinematic"], world["ground"].move, (0, 0, 0))
    refused(["robot", "position"], world["robot"].move, position=(0, 0, NAN))
    refused(["robot", "orientation"], world["robot"].move, orientation=(0, 0, 0, 0))
    refused(["robot", "linear_velocity"], world["robot"].move, linear_velocity=(0, 0))
    refused(["robot", "angular_velocity"], world["robot"].move, angular_velocity=(0, INF, 0))


def test_removed_and_foreign_bodies():
    world, other = new_world(), new_world()
    ball = world["ball"]
    refused(["ball", "not in this world"], other.remove, ball)
    world.remove(ball)
    refused(["ball", "removed"], lambda: ball.position)
    refused(["ball"], world.remove, ball)
    with pytest.raises(KeyError, match="no body is named 'ball'; bodies: ground, robot"):
        world["ball"]


def test_queries():
    world, other = new_world(), new_world()
    ball, ground = world["ball"], world["ground"]
    for query in (rb.test_intersection, rb.find_contacts, rb.distance):
        refused(["different worlds"], query, ball, other["ground"])
        refused(["two bodies", "'ball'"], query, ball, ball)
    refused(["t_max"], rb.time_of_impact, ball, ground, -1.0)
    refused(["t_max"], rb.time_of_impact, ball, ground, NAN)
    refused(["margin"], rb.find_contacts, ball, ground, margin=-1.0)
    refused(["contact row 5", "0 rows"], rb.contact_kinematics, world, 5)
    refused(["direction"], world.ray_cast, (0, 0, 0), (0, 0, 0))
    refused(["origin"], world.ray_cast, (0, 0, NAN), (0, 0, 1))


@pytest.mark.parametrize("snapshot", [b"", b"nonsense", "cut", "longer", "other world"])
def test_snapshots(snapshot):
    world = new_world()
    world.step(3)
    before = world.state_hash
    good = world.save()
    if snapshot == "cut":
        snapshot = good[:-5]
    elif snapshot == "longer":
        snapshot = good + b"x"
    elif snapshot == "other world":
        larger = new_world()
        larger.add_body(rb.Sphere(0.1), mass=1.0, position=(5, 5, 5))
        snapshot = larger.save()
    refused(["snapshot"], world.restore, snapshot)
    assert world.state_hash == before  # refused as a whole


@pytest.mark.parametrize("count", [-1, 1.5, "3", None])
def test_number_of_steps(count):
    world = new_world()
    with pytest.raises((rb.SceneError, TypeError)):
        world.step(count)
    assert world.time == 0.0


def test_diverging_raises_and_keeps_the_last_good_state():
    world = new_world(dt=1.0)
    world.step()
    good = world["ball"].position
    world["ball"].apply_wrench(force=(1e308, 0, 0))
    with pytest.raises(rb.DivergedError, match="ball") as caught:
        world.step(10)
    assert caught.value.body == "ball"
    assert caught.value.step >= 1
    assert np.isfinite(world.positions).all()
    assert np.isfinite(world.linear_velocities).all()
    assert np.isfinite(good).all()
