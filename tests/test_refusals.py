"""Every function and property of the Python face, called with values of the wrong kind: what is not
taken is refused by SceneError in one line that names the argument, and nothing has changed."""

import dataclasses
import math

import numpy as np
import pytest

import rb_physics as rb

NAN, INF = math.nan, math.inf
UP, AT_REST = (0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 1.0)

# No number, vector, matrix, word, shape, body or world among them is right for any argument.
WRONG = [
    None, b"x", "", NAN, INF, -INF, 10**400, 1j, (), [], {}, {1, 2, 3}, object(), print,
    (1.0, 2.0), (0.0, 0.0, NAN), (0.0, INF, 0.0), ("1", "2", "3"), (True, False, True), (1j, 2, 3),
    (None, None, None), [[1, 2], [3]], np.full((3, 3), NAN), np.zeros((3, 0)), np.array(NAN),
    np.array([1, 2, 3], dtype="datetime64[D]"), np.array(["1", "2", "3"]), np.ones(5), 10**5000,
]  # fmt: skip
IDS = [str(i) for i in range(len(WRONG))]


def new_world():
    world = rb.World()
    world.add_body(rb.HalfSpace(normal=UP, offset=0.0), type="static", name="ground")
    world.add_body(rb.Sphere(0.1), mass=1.0, position=(0, 0, 0.1), name="ball")
    world.add_body(rb.Box((0.1, 0.1, 0.1)), type="kinematic", position=(3, 0, 0), name="robot")
    world.step()
    return world


def adding(field):
    given = {"mass": 1.0} if field != "density" else {}
    return lambda w, v: w.add_body(rb.Box((1, 1, 1)), **{"name": "crate", **given, field: v})


def setting(body, field):
    return lambda w, v: setattr(w[body], field, v)


def batch_setting(field):
    return lambda w, v: setattr(rb.Batch(w, 2), field, v)


def replacing(function, good, i):
    return lambda w, v: function(*good[:i], v, *good[i + 1 :])


# Values of WRONG that mean something after all: for these arguments None is "not given", and so on.
NONE = {0}
CALLS = {
    **{
        f"add_body {f}": (adding(f), f, NONE if f in ("inertia", "center_of_mass") else set())
        for f in (
            "type",
            "position",
            "orientation",
            "inertia",
            "center_of_mass",
            "linear_velocity",
            "angular_velocity",
            "friction",
            "restitution",
            "rolling_friction",
            "spinning_friction",
        )
    },
    "add_body name": (adding("name"), "body name", NONE),
    "add_body mass": (adding("mass"), "mass", set()),
    "add_body density": (adding("density"), "density", set()),
    "add_body static_friction": (adding("static_friction"), "static_friction", NONE),
    "add_body frames": (adding("frames"), "frames", {0, 10}),
    "add_body shape": (lambda w, v: w.add_body(v, mass=1.0, name="crate"), "shape", set()),
    **{
        f"Settings {f.name}": (
            lambda w, v, name=f.name: rb.Settings(**{name: v}),
            f.name,
            NONE if f.name == "restitution_threshold" else set(),
        )
        for f in dataclasses.fields(rb.Settings)
    },
    "World": (lambda w, v: rb.World(v), "settings", NONE),
    "step": (lambda w, v: w.step(v), "n", set()),
    "step_count": (lambda w, v: setattr(w, "step_count", v), "step_count", set()),
    "keep_hashes": (lambda w, v: setattr(w, "keep_hashes", v), "keep_hashes", set()),
    "restore": (lambda w, v: w.restore(v), "snapshot", set()),
    "remove": (lambda w, v: w.remove(v), "body", set()),
    "ray_cast origin": (lambda w, v: w.ray_cast(v, UP), "origin", set()),
    "ray_cast direction": (lambda w, v: w.ray_cast(UP, v), "direction", set()),
    **{
        f"body.{f}": (setting("ball", f), f, set())
        for f in (
            "position",
            "orientation",
            "com_position",
            "linear_velocity",
            "angular_velocity",
            "friction",
            "static_friction",
            "restitution",
            "rolling_friction",
            "spinning_friction",
        )
    },
    **{
        f"apply_wrench {f}": (lambda w, v, f=f: w["ball"].apply_wrench(**{f: v}), f, allowed)
        for f, allowed in {
            "force": set(),
            "torque": set(),
            "point": NONE,
            "frame": set(),
            "duration": NONE,
            "source": set(),
        }.items()
    },
    "clear_wrenches": (lambda w, v: w["ball"].clear_wrenches(v), "source", NONE),
    "apply_impulse": (lambda w, v: w["ball"].apply_impulse(v), "impulse", set()),
    "apply_impulse point": (lambda w, v: w["ball"].apply_impulse(UP, v), "point", NONE),
    **{
        f"move {f}": (lambda w, v, f=f: w["robot"].move(**{f: v}), f, NONE)
        for f in ("position", "orientation", "linear_velocity", "angular_velocity")
    },
    **{
        f"{f} {which}": (
            lambda w, v, f=f, which=which: getattr(rb, f)(
                *((v, w["ball"]) if which == "a" else (w["ball"], v)),
                *((1.0,) if f == "time_of_impact" else ()),
            ),
            which,
            set(),
        )
        for f in ("test_intersection", "find_contacts", "distance", "time_of_impact")
        for which in "ab"
    },
    "margin": (lambda w, v: rb.find_contacts(w["ball"], w["ground"], v), "margin", set()),
    "t_max": (lambda w, v: rb.time_of_impact(w["ball"], w["ground"], v), "t_max", set()),
    "contact_kinematics world": (lambda w, v: rb.contact_kinematics(v, 0), "world", set()),
    "contact_kinematics i": (lambda w, v: rb.contact_kinematics(w, v), "i", set()),
    "Batch world": (lambda w, v: rb.Batch(v, 2), "world", set()),
    "Batch n": (lambda w, v: rb.Batch(w, v), "n", set()),
    "Batch threads": (lambda w, v: rb.Batch(w, 2, v), "threads", NONE),
    "Batch step": (lambda w, v: rb.Batch(w, 2).step(v), "n", set()),
    "Batch item": (lambda w, v: rb.Batch(w, 2)[v], "variation", set()),
    **{
        f"Batch {f}": (batch_setting(f), f, set())
        for f in ("positions", "orientations", "linear_velocities", "angular_velocities")
    },
    "Batch forces": (lambda w, v: rb.Batch(w, 2).apply_wrenches(v), "forces", set()),
    "Batch torques": (
        lambda w, v: rb.Batch(w, 2).apply_wrenches(np.zeros((2, 3, 3)), v),
        "torques",
        NONE,
    ),
    "Batch duration": (
        lambda w, v: rb.Batch(w, 2).apply_wrenches(np.zeros((2, 3, 3)), None, v),
        "duration",
        NONE,
    ),
    "load_scene": (lambda w, v: rb.load_scene(v), "scene", set()),
    "from_yaml": (lambda w, v: rb.Scene.from_yaml(v), "", set()),
    "build dt": (lambda w, v: rb.load_scene("demo").build(dt=v), "dt", set()),
    **{
        f"{shape.__name__} {field}": (
            replacing(shape, good, i),
            f"shape.{field}" if shape not in (rb.TriangleMesh, rb.HeightField) else field,
            {14} if field == "spacing" else set(),  # two lengths
        )
        for shape, good, fields in (
            (rb.Sphere, (1.0,), ["radius"]),
            (rb.Box, ((1, 1, 1),), ["half_extents"]),
            (rb.Capsule, (1.0, 1.0), ["radius", "half_length"]),
            (rb.Cylinder, (1.0, 1.0), ["radius", "half_length"]),
            (rb.HalfSpace, (UP, 0.0), ["normal", "offset"]),
            (rb.ConvexHull, (np.eye(4, 3),), ["points"]),
            (rb.Compound, ([],), ["parts"]),
            (rb.TriangleMesh, (np.eye(3), [[0, 1, 2]]), ["vertices", "triangles"]),
            (rb.HeightField, (np.zeros((3, 3)), 1.0), ["heights", "spacing"]),
        )
        for i, field in enumerate(fields)
    },
    **{
        f"Compound part {i}": (
            lambda w, v, i=i: rb.Compound(
                [tuple(v if k == i else g for k, g in enumerate((rb.Sphere(1), UP, AT_REST)))]
            ),
            "shape.parts[0]",
            set(),
        )
        for i in range(3)
    },
    "Compound part": (lambda w, v: rb.Compound([v]), "shape.parts[0]", set()),
    **{
        f"math.{name} {fields[i]}": (replacing(getattr(rb.math, name), good, i), fields[i], set())
        for name, good, fields in (
            ("skew", [UP], ["u"]),
            ("rotation_derivative", [np.eye(3), UP], ["rotation", "angular_velocity"]),
            ("gram_schmidt", [np.eye(3)], ["rotation"]),
            ("quaternion_derivative", [AT_REST, UP], ["orientation", "angular_velocity"]),
            ("normalize", [AT_REST], ["orientation"]),
            ("rotation_matrix", [AT_REST], ["orientation"]),
            ("quaternion", [np.eye(3)], ["rotation"]),
            ("quaternion_multiply", [AT_REST, AT_REST], ["a", "b"]),
            ("quaternion_from_rotation_vector", [UP], ["vector"]),
            ("rotation_vector", [AT_REST], ["orientation"]),
            ("rotate", [AT_REST, UP], ["orientation", "vector"]),
            ("contact_frame", [UP], ["normal"]),
            ("sin", [1.0], ["x"]),
            ("cos", [1.0], ["x"]),
            ("atan2", [1.0, 1.0], ["y", "x"]),
        )
        for i in range(len(good))
    },
}


@pytest.mark.parametrize("call", CALLS)
def test_wrong_kinds_are_refused(call):
    act, field, allowed = CALLS[call]
    world = new_world()
    before = world.state_hash
    for i, value in enumerate(WRONG):
        if i in allowed:
            continue
        with pytest.raises(rb.SceneError) as caught:
            act(world, value)
        message = str(caught.value)
        assert field in message, f"{value!r:.60}: {message}"
        assert "\n" not in message
        assert len(message) < 700
    assert world.state_hash == before
    assert [b.name for b in world.bodies] == ["ground", "ball", "robot"]


MESSAGES = [
    (lambda w: w.step(-1), "n is -1; it must be a whole number ≥ 0"),
    (lambda w: w.step(True), "n is True; it must be a whole number ≥ 0"),
    (
        lambda w: w.step(10**30),
        "n is 1000000000000000000000000000000; it must be a whole number of",
    ),
    (lambda w: rb.Batch(w, 2).step(-1), "n is -1; it must be a whole number ≥ 0"),
    (lambda w: rb.Sphere("a"), "shape.radius is 'a'; it must be a length between 1e-9 and 1e9 m"),
    (lambda w: w.restore("x"), "snapshot is 'x'; it must be the bytes that `save` returned"),
    (lambda w: rb.distance("a", "b"), "a is 'a'; it must be a body of a world: world['NAME']"),
    (lambda w: rb.World(settings={}), "settings is {}; it must be rb.Settings(...)"),
    (lambda w: rb.load_scene(3), "scene is 3; it must be the path of a scene file or the name of"),
    (lambda w: rb.World(stepper="fixd"), "'fixed' or 'event' (did you mean 'fixed'?)"),
    (lambda w: adding("frames")(w, [1]), "body 'crate': frames is [1]; it must be a dict"),
    (
        lambda w: adding("frames")(w, {"world": (UP, AT_REST)}),
        "body 'crate': frame name is 'world'; it must be a letter",
    ),
    (
        lambda w: adding("inertia")(w, (1, 1, 2.00001)),
        "two (2.00001 > 1.0 + 1.0)",
    ),
    (
        lambda w: adding("inertia")(w, [[1, 0, 0], [0, 1, 2e-9], [0, 0, 1]]),
        "symmetric ([1, 2] is 2e-09, [2, 1] is 0.0)",
    ),
    (
        lambda w: w["ball"].set_material(frictoin=1.0),
        "body 'ball': unknown property of a surface 'frictoin'; did you mean 'friction'?",
    ),
    (lambda w: rb.math.rotation_matrix((0, 0, 0, 0)), "a unit quaternion x y z w (`normalize`"),
    (lambda w: rb.math.normalize((0, 0, 0, 0)), "a quaternion x y z w of length > 0"),
    (lambda w: rb.math.quaternion(np.zeros((3, 3))), "a rotation matrix: orthonormal columns"),
    (lambda w: rb.math.quaternion(np.diag([1, 1, -1])), "a rotation matrix: orthonormal columns"),
    (lambda w: rb.math.contact_frame((0, 0, 2)), "normal is (0, 0, 2); it must be a unit vector"),
    (lambda w: rb.math.sin(1e13), "x is 10000000000000.0; it must be a finite number of at most"),
    (
        lambda w: batch_setting("positions")(w, np.zeros((2, 2, 3))),
        "it must be an array of numbers of shape (2, 3, 3): variations, bodies, axes",
    ),
    (
        lambda w: batch_setting("linear_velocities")(w, np.where(np.eye(3)[None] * 0 == 1, 0, NAN)),
        "linear_velocities is",
    ),
    (
        lambda w: batch_setting("orientations")(w, np.full((2, 3, 4), 0.6)),
        "body 'ground': orientations[0, 0] is [0.6, 0.6, 0.6, 0.6]; it must be one of unit quat",
    ),
    (
        lambda w: setattr(w.add_body(rb.Sphere(1), mass=1e9), "linear_velocity", (1e300, 0, 0)),
        "it must be so small that position and momenta stay finite",
    ),
    (lambda w: rb.load_scene("demo").build(dt=-1), "dt is -1; it must be a finite number > 0 (s)"),
    (lambda w: rb.load_scene("demo").build(dtt=1), "unknown setting 'dtt'; did you mean 'dt'?"),
    (
        lambda w: w.add_body(rb.Sphere(1), mass=1, frction=0.3),
        "add_body has no argument 'frction'; did you mean 'friction'?",
    ),
]


@pytest.mark.parametrize(("act", "words"), MESSAGES, ids=lambda v: v[:40] if v is str else None)
def test_messages(act, words):
    with pytest.raises(rb.SceneError) as caught:
        act(new_world())
    assert words in str(caught.value)
    assert ".yaml:" not in str(caught.value)  # none of these is a mistake in a file


def test_one_bad_row_of_a_batch_is_named_and_none_is_set():
    world = new_world()
    batch = rb.Batch(world, 2)
    positions = np.array(batch.positions)
    positions[1, 1, 2] = NAN
    with pytest.raises(rb.SceneError, match=r"body 'ball': positions\[1, 1\] is \[0.0, 0.0, nan\]"):
        batch.positions = positions
    velocities = np.zeros((2, 3, 3))
    velocities[:, 1:, 0] = 1.0
    batch.linear_velocities = velocities
    before = batch.state_hashes
    heavy = world.add_body(rb.Sphere(0.1), mass=1e9, position=(9, 9, 9), name="heavy")
    twins = rb.Batch(world, 2)
    fast = np.zeros((2, 4, 3))
    fast[:, heavy.row] = 1e301
    same = twins.state_hashes
    with pytest.raises(rb.SceneError, match="'heavy': linear_velocities"):
        twins.linear_velocities = fast
    assert (twins.state_hashes == same).all()
    assert (batch.state_hashes == before).all()
