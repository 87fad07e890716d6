"""Contact times against closed forms, and no impact missed against fine time stepping."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from rb_physics import _core

Motion, Sphere, Box, HalfSpace = _core.Motion, _core.Sphere, _core.Box, _core.HalfSpace
GROUND = HalfSpace((0, 0, 1), 0.0)
REST = Motion()

# Times below are of order 1 s and speeds of order 1 m/s: positions are rounded at 1e-16 m, so times
# come out within a few 1e-16 s. The promise is 1e-10.
TIME = 1e-12


def impact(a, motion_a, b, motion_b, t_max):
    time, iterations, converged = _core.time_of_impact(a, motion_a, b, motion_b, t_max)
    assert converged, iterations
    return time


def test_falling_sphere():
    motion = Motion(
        position=(0, 0, 1),
        linear_velocity=(0.3, 0, -0.2),
        acceleration=(0, 0, -9.81),
        angular_velocity=(1, 20, 3),
    )
    exact = (-0.2 + np.sqrt(0.2**2 + 2 * 9.81 * 0.9)) / 9.81
    assert impact(Sphere(0.1), motion, GROUND, REST, 2.0) == pytest.approx(exact, abs=TIME)
    assert impact(GROUND, REST, Sphere(0.1), motion, 2.0) == pytest.approx(exact, abs=TIME)
    assert impact(Sphere(0.1), motion, GROUND, REST, exact - 1e-9) is None
    assert impact(Sphere(0.1), motion, GROUND, REST, exact + 1e-9) == pytest.approx(exact, abs=TIME)


def test_two_spheres():
    rng = np.random.default_rng(0)
    for _ in range(1000):
        ra, rb = rng.uniform(0.1, 0.6, 2)
        p, v, w = rng.normal(size=3) * 2, rng.normal(size=3), rng.normal(size=3)
        if np.linalg.norm(p) < 1.001 * (ra + rb):
            continue
        found = impact(
            Sphere(ra),
            Motion(position=p, linear_velocity=v + w, angular_velocity=10 * w),
            Sphere(rb),
            Motion(linear_velocity=w),
            5.0,
        )
        along, gap = p @ v, p @ p - (ra + rb) ** 2
        discriminant = along**2 - v @ v * gap
        exact = None
        if discriminant >= 0 and along < 0:
            exact = (-along - np.sqrt(discriminant)) / (v @ v)
            if exact > 5:
                exact = None
        if exact is None:
            assert found is None
        else:
            # A root is as uncertain as its discriminant is small.
            tolerance = TIME + 1e-15 / np.sqrt(max(discriminant, 1e-15))
            assert found == pytest.approx(exact, abs=tolerance)


def test_corner_of_a_turning_box():
    half = np.array([0.3, 0.2, 0.1])
    rho, start = np.hypot(0.3, 0.1), np.arctan2(0.3, 0.1)  # corner, seen from the axis y
    for omega, height in [(1.0, 0.2), (30.0, 0.315), (-7.0, 0.12)]:
        exact = (start - np.arccos(height / rho)) / abs(omega)
        found = impact(
            Box(half),
            Motion(position=(0, 0, height), angular_velocity=(0, omega, 0)),
            GROUND,
            REST,
            2.0,
        )
        assert found == pytest.approx(exact, abs=TIME)


def test_rolling_cylinder_meets_a_wall():
    """Rolls without slipping on the ground at v: its side reaches the wall after (d - r) / v."""
    r, v, d = 0.2, 0.7, 1.3
    lying = (np.sin(np.pi / 4), 0, 0, np.cos(np.pi / 4))  # axis along y
    motion = Motion(
        position=(0, 0, r),
        orientation=lying,
        linear_velocity=(v, 0, 0),
        angular_velocity=(0, v / r, 0),
    )
    cylinder = _core.Cylinder(r, 0.5)
    assert impact(cylinder, motion, HalfSpace((-1, 0, 0), -d), REST, 5.0) == pytest.approx(
        (d - r) / v, abs=TIME
    )
    wall = Motion(position=(d + 0.1, 0, 0))
    assert impact(cylinder, motion, Box((0.1, 2, 2)), wall, 5.0) == pytest.approx(
        (d - r) / v, abs=1e-10
    )


def test_tumbling_boxes_on_the_ground():
    rng = np.random.default_rng(1)
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    for _ in range(30):
        half, omega = rng.uniform(0.05, 0.3, 3), 20 * rng.normal(size=3)
        speed = rng.uniform(0, 3)
        motion = Motion(
            position=(0, 0, 1.5),
            linear_velocity=(0, 0, -speed),
            acceleration=(0, 0, -9.81),
            angular_velocity=omega,
        )

        def lowest(t):
            corners = Rotation.from_rotvec(omega * t).apply(signs * half)  # noqa: B023
            return 1.5 - speed * t - 9.81 / 2 * t * t + corners[:, 2].min()  # noqa: B023

        times = np.linspace(0, 2, 2001)
        first = np.argmax([lowest(t) < 0 for t in times])
        exact = brentq(lowest, times[first - 1], times[first], xtol=1e-15, rtol=1e-15)
        found = impact(Box(half), motion, GROUND, REST, 2.0)
        assert found <= exact + TIME  # the sampled root may be a later one
        assert abs(lowest(found)) < 1e-14


@pytest.mark.parametrize("overlap", [1e-3, 1e-8, 0.0])
def test_grazing_spheres(overlap):
    motion = Motion(position=(-3, 1 - overlap, 0), linear_velocity=(1, 0, 0))
    exact = 3 - np.sqrt(1 - (1 - overlap) ** 2)
    # Near a double root a gap of 1e-14 m, rounding, is a time of 1e-7 s.
    tolerance = 2e-7 if overlap == 0 else 1e-10
    assert impact(Sphere(0.5), motion, Sphere(0.5), REST, 10.0) == pytest.approx(
        exact, abs=tolerance
    )


@pytest.mark.parametrize("gap", [1e-3, 1e-8, 1e-12])
def test_spheres_that_pass_by(gap):
    motion = Motion(position=(-3, 1 + gap, 0), linear_velocity=(1, 0, 0))
    time, iterations, converged = _core.time_of_impact(Sphere(0.5), motion, Sphere(0.5), REST, 10.0)
    assert (time, converged) == (None, True)
    assert iterations < 100  # grows with the logarithm of the gap only


@pytest.mark.parametrize(
    ("speed", "acceleration", "exact"),
    [
        (-1.0, 0.0, 0.0),  # touches and approaches: an impact now
        (0.0, 0.0, None),  # rests
        (0.0, -9.81, 0.0),  # touches, and gravity takes it in
        (1.0, 0.0, None),  # parts
        (1.0, -9.81, 2 / 9.81),  # parts and comes back
    ],
)
def test_touching_at_the_start(speed, acceleration, exact):
    motion = Motion(
        position=(0, 0, 0.5), linear_velocity=(0.3, 0, speed), acceleration=(0, 0, acceleration)
    )
    found = impact(Sphere(0.5), motion, GROUND, REST, 1.0)
    assert found == (None if exact is None else pytest.approx(exact, abs=TIME))


@pytest.mark.parametrize(("speed", "exact"), [(-1.0, 0.0), (0.0, None), (1.0, None)])
def test_overlapping_at_the_start(speed, exact):
    motion = Motion(position=(0, 0, 0.4), linear_velocity=(0, 0, speed))
    assert impact(Sphere(0.5), motion, GROUND, REST, 1.0) == exact


def test_box_sliding_on_a_box_is_no_impact():
    motion = Motion(position=(0, 0, 0.1), linear_velocity=(1, 0, 0))
    assert (
        impact(Box((0.1, 0.1, 0.1)), motion, Box((1, 1, 1)), Motion(position=(0, 0, -1)), 1.0)
        is None
    )


def random_motion(rng, position, toward, spin):
    orientation = rng.normal(size=4)
    return Motion(
        position=position,
        orientation=orientation / np.linalg.norm(orientation),
        linear_velocity=toward + 0.3 * rng.normal(size=3),
        acceleration=0.5 * rng.normal(size=3),
        angular_velocity=spin * rng.normal(size=3),
    )


def shapes(rng):
    return [
        Sphere(rng.uniform(0.1, 0.4)),
        Box(rng.uniform(0.05, 0.4, 3)),
        _core.Capsule(rng.uniform(0.05, 0.2), rng.uniform(0.05, 0.4)),
        _core.Cylinder(rng.uniform(0.05, 0.3), rng.uniform(0.05, 0.4)),
        _core.ConvexHull(0.3 * rng.normal(size=(10, 3))),
    ]


def trajectories(seed, count):
    rng = np.random.default_rng(seed)
    for _ in range(count):
        a, b = rng.choice(shapes(rng)), rng.choice(shapes(rng))
        p = rng.normal(size=3)
        p *= 2 / np.linalg.norm(p)
        spin = rng.choice([0.0, 1.0, 5.0, 30.0])
        yield (
            a,
            random_motion(rng, p, -rng.uniform(0.2, 3) * p, spin),
            b,
            random_motion(rng, np.zeros(3), 0, spin),
        )


def compare_with_time_stepping(a, motion_a, b, motion_b, steps=200, t_max=1.0):
    """Before the time found the shapes are apart at every sample; at it they touch."""

    def gap(t):
        return _core.distance(a, *motion_a.at(t), b, *motion_b.at(t))[0]

    found, _, converged = _core.time_of_impact(a, motion_a, b, motion_b, t_max)
    for t in np.linspace(0, t_max if found is None else found, steps)[
        : None if found is None else -1
    ]:
        assert gap(t) > 0, (t, found)
    if not converged:  # says so, and up to the time it gives nothing met
        return None
    if found is not None:
        assert abs(gap(found)) < 1e-11  # speeds of 1 m/s, times to 1e-12 s
    return found is not None


def test_no_impact_is_missed():
    outcomes = [compare_with_time_stepping(*case) for case in trajectories(0, 500)]
    assert None not in outcomes
    assert 100 < sum(outcomes) < 500  # both outcomes were met


@pytest.mark.soak
def test_no_impact_is_missed_in_many_trajectories():
    outcomes = [compare_with_time_stepping(*case) for case in trajectories(1, 100_000)]
    assert None not in outcomes
    assert 20_000 < outcomes.count(True) < 100_000


@pytest.mark.parametrize("spin", [0.0, 1000.0])
@pytest.mark.parametrize(
    "bullet",
    [
        Sphere(0.002),
        Box((0.002, 0.001, 0.003)),
        _core.Capsule(0.001, 0.002),
        _core.Cylinder(0.001, 0.002),
        _core.ConvexHull(0.002 * np.vstack([np.eye(3), -np.eye(3)])),
    ],
    ids=lambda shape: type(shape).__name__,
)
def test_a_bullet_does_not_pass_a_thin_wall(bullet, spin):
    """100 m/s, 1 mm wall, 5 ms: a fixed step would be 0.5 m."""
    rng = np.random.default_rng(2)
    wall = Box((0.0005, 1, 1))
    for _ in range(20):
        start = rng.uniform(-0.49, -0.01)
        motion = Motion(
            position=(start, *rng.uniform(-0.5, 0.5, 2)),
            linear_velocity=(100, 0, 0),
            angular_velocity=(0, spin, spin / 2),
        )
        found = impact(bullet, motion, wall, REST, 0.005)
        assert found is not None
        reach = found * 100 + start + 0.0005  # wall's near side minus the bullet's centre
        assert -0.004 <= reach <= -0.0009


@pytest.mark.parametrize("t_max", [-1.0, float("nan"), float("inf")])
def test_bad_interval(t_max):
    with pytest.raises(ValueError, match="t_max"):
        _core.time_of_impact(Sphere(1), REST, Sphere(1), REST, t_max)


def test_two_half_spaces_are_refused():
    with pytest.raises(ValueError, match="half-spaces"):
        _core.time_of_impact(GROUND, REST, GROUND, REST, 1.0)
