"""d, its speed and its acceleration (S10) against finite differences of the true distance along the
true motion: x(t) = c + v t + a t^2 / 2, R(t) = exp(omega t + alpha t^2 / 2) R."""

import numpy as np
import pytest

from rb_physics import _core

SPHERE, BOX = _core.Sphere(0.3), _core.Box((0.3, 0.4, 0.5))
GROUND = _core.HalfSpace((0, 0, 1), 0.0)
IDENTITY = np.array([0, 0, 0, 1.0])


def product(a, b):
    """Quaternions (x, y, z, w)."""
    return np.append(
        a[3] * b[:3] + b[3] * a[:3] + np.cross(a[:3], b[:3]), a[3] * b[3] - a[:3] @ b[:3]
    )


def exponential(v):
    angle = np.linalg.norm(v)
    if angle == 0:
        return IDENTITY
    return np.append(np.sin(angle / 2) / angle * v, np.cos(angle / 2))


class Motion:
    """Rows of `rates`: centre, velocity, angular velocity, acceleration, angular acceleration."""

    def __init__(self, position, orientation, rates):
        self.position, self.orientation = np.array(position, float), np.array(orientation, float)
        self.rates = np.array(rates, float)

    def at(self, t):
        center, v, omega, a, alpha = self.rates
        turn = exponential(omega * t + alpha * t * t / 2)
        arm = self.position - center
        turned = product(product(turn, np.append(arm, 0)), turn * [-1, -1, -1, 1])[:3]
        return center + v * t + a * t * t / 2 + turned, product(turn, self.orientation)


def random_rates(rng, position):
    return np.vstack([position + rng.normal(0, 0.1, 3), rng.normal(size=(4, 3))])


def check(a, motion_a, b, motion_b, index=None):
    """All contacts of the pair when index is None."""

    def distance(t):
        return _core.distance(a, *motion_a.at(t), b, *motion_b.at(t))[0]

    h = 1e-3
    d = {k: distance(k * h) for k in range(-2, 3)}
    # Fourth order: truncation h^4 (about 1e-12, times fifth and sixth derivatives up to 1e4 here),
    # rounding 1e-15 / h^2.
    speed = (d[-2] - 8 * d[-1] + 8 * d[1] - d[2]) / (12 * h)
    acceleration = (-d[-2] + 16 * d[-1] - 30 * d[0] + 16 * d[1] - d[2]) / (12 * h * h)
    k = _core.contact_kinematics(
        a, *motion_a.at(0), motion_a.rates, b, *motion_b.at(0), motion_b.rates, 10.0, index or 0
    )
    scale = 1 + abs(acceleration)
    assert k[0] == pytest.approx(d[0], abs=1e-13)
    assert k[1] == pytest.approx(speed, abs=1e-8 * scale)
    assert k[2] == pytest.approx(acceleration, abs=1e-6 * scale)
    return k


def fixed():
    return Motion((0, 0, 0), IDENTITY, np.zeros((5, 3)))


def unit_quaternion(rng):
    q = rng.normal(size=4)
    return q / np.linalg.norm(q)


@pytest.mark.parametrize("seed", range(10))
def test_two_spheres(seed):
    rng = np.random.default_rng(seed)
    p, q = rng.normal(size=3), rng.normal(size=3) + np.array([2, 0, 0])
    a = Motion(p, unit_quaternion(rng), random_rates(rng, p))
    b = Motion(q, unit_quaternion(rng), random_rates(rng, q))
    check(SPHERE, a, _core.Sphere(0.2), b)


@pytest.mark.parametrize("seed", range(10))
def test_sphere_on_moving_half_space(seed):
    rng = np.random.default_rng(seed)
    p = np.array([0.2, 0.1, 0.35])
    a = Motion(p, unit_quaternion(rng), random_rates(rng, p))
    b = Motion((0, 0, 0), unit_quaternion(rng), random_rates(rng, np.zeros(3)))
    check(SPHERE, a, GROUND, b)


@pytest.mark.parametrize("seed", range(10))
def test_box_corner_on_moving_half_space(seed):
    rng = np.random.default_rng(seed)
    p = np.array([0.2, 0.1, 1.0])
    a = Motion(p, unit_quaternion(rng), random_rates(rng, p))
    b = Motion((0, 0, 0), IDENTITY, random_rates(rng, np.zeros(3)))

    def nearest(motion_a, motion_b):
        points = _core.find_contacts(BOX, *motion_a.at(0), GROUND, *motion_b.at(0), 10.0)
        return int(np.argmin(points["separation"]))

    check(BOX, a, GROUND, b, nearest(a, b))


@pytest.mark.parametrize("where", [(0.1, 0.2, 0.9), (0.1, 0.75, 0.85), (0.6, 0.75, 0.85)])
@pytest.mark.parametrize("seed", range(5))
def test_sphere_at_face_edge_and_corner_of_a_turning_box(where, seed):
    rng = np.random.default_rng(seed)
    a = Motion(where, unit_quaternion(rng), random_rates(rng, np.array(where)))
    b = Motion((0, 0, 0), IDENTITY, random_rates(rng, np.zeros(3)))
    check(SPHERE, a, BOX, b)


def edges_met(rng):
    """Poses of two boxes whose nearest features are an edge each."""
    while True:
        qa, qb = unit_quaternion(rng), unit_quaternion(rng)
        p = rng.normal(size=3)
        p *= 1.6 / np.linalg.norm(p)
        points = _core.find_contacts(BOX, p, qa, BOX, np.zeros(3), qb, 10.0)
        if len(points["kind"]) == 1 and points["kind"][0] == 1 and points["separation"][0] > 0.01:
            return p, qa, qb


@pytest.mark.parametrize("seed", range(10))
def test_edge_against_edge(seed):
    rng = np.random.default_rng(seed)
    p, qa, qb = edges_met(rng)
    a = Motion(p, qa, random_rates(rng, p))
    b = Motion((0, 0, 0), qb, random_rates(rng, np.zeros(3)))
    check(BOX, a, BOX, b)


CAPSULE, CYLINDER = _core.Capsule(0.2, 0.4), _core.Cylinder(0.3, 0.5)


def quaternion(axis, angle):
    return np.append(np.sin(angle / 2) * np.array(axis, float), np.cos(angle / 2))


@pytest.mark.parametrize(
    ("shape", "position", "orientation", "other"),
    [
        # on a plane: end of a leaning capsule, rim of a leaning cylinder
        (CAPSULE, (0, 0, 0.6), quaternion((1, 0, 0), 0.4), GROUND),
        (CYLINDER, (0, 0, 0.7), quaternion((1, 0, 0), 0.4), GROUND),
        # lines that cross: the sides of two capsules, a side and the edge of a box
        (CAPSULE, (0.05, 0.1, 0.5), quaternion((1, 0, 0), 1.4), CAPSULE),
        (CAPSULE, (0.45, 0.02, 0.75), quaternion((0.6, 0, 0.8), 1.5), BOX),
        # ball against the side and the end of a capsule, the side and the rim of a cylinder
        (SPHERE, (0.6, 0.1, 0.1), IDENTITY, CAPSULE),
        (SPHERE, (0.3, 0.1, 0.8), IDENTITY, CAPSULE),
        (SPHERE, (0.7, 0.1, 0.1), IDENTITY, CYLINDER),
        (SPHERE, (0.5, 0.1, 0.8), IDENTITY, CYLINDER),
    ],
)
@pytest.mark.parametrize("seed", range(4))
def test_capsules_and_cylinders(shape, position, orientation, other, seed):
    rng = np.random.default_rng(seed)
    a = Motion(position, orientation, random_rates(rng, np.array(position)))
    b = Motion((0, 0, 0), IDENTITY, random_rates(rng, np.zeros(3)))
    points = _core.find_contacts(shape, *a.at(0), other, *b.at(0), 10.0)
    check(shape, a, other, b, int(np.argmin(points["separation"])))


def test_the_extra_terms_of_the_notes():
    """A vertex at rest over a face that turns: d'' = 2 N'.(...) + N''.(...) alone makes it up."""
    a = Motion((0.5, 0, 0.2), IDENTITY, np.zeros((5, 3)))
    omega = 2.0
    b = Motion((0, 0, 0), IDENTITY, [[0, 0, 0], [0, 0, 0], [0, omega, 0], [0, 0, 0], [0, 0, 0]])
    d, d_dot, d_ddot, normal_rate = check(_core.Particle(), a, GROUND, b)
    # N = (sin wt, 0, cos wt), P_A = (0.5, 0, 0.2): d = 0.5 sin wt + 0.2 cos wt.
    assert d == pytest.approx(0.2, abs=1e-15)
    assert d_dot == pytest.approx(0.5 * omega, abs=1e-15)
    assert d_ddot == pytest.approx(-0.2 * omega**2, abs=1e-15)
    np.testing.assert_allclose(normal_rate, [omega, 0, 0], atol=1e-15)


def test_a_ball_that_rolls_keeps_touching():
    r, v = 0.3, 1.7
    rates = [[0, 0, r], [v, 0, 0], [0, v / r, 0], [0, 0, 0], [0, 0, 0]]
    d, d_dot, d_ddot, _ = check(SPHERE, Motion((0, 0, r), IDENTITY, rates), GROUND, fixed())
    # The material point accelerates upwards by v^2 / r; the contact point wanders and cancels it.
    assert (d, d_dot) == (0.0, pytest.approx(0.0, abs=1e-15))
    assert d_ddot == pytest.approx(0.0, abs=1e-14)
