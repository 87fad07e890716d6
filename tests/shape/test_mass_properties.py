"""Mass, centre of mass and inertia at unit density against closed forms and other integrals."""

import numpy as np
import pytest

from rb_physics import _core as core
from tests import oracles

# Sums of a few dozen terms: rounding is some 1e-15, relative.
ROUNDING = 1e-12


def same(found, mass, center, inertia):
    scale = np.abs(inertia).max()
    assert found[0] == pytest.approx(mass, rel=ROUNDING)
    assert found[1] == pytest.approx(center, abs=ROUNDING * (1 + np.abs(center).max()))
    assert found[2] == pytest.approx(inertia, abs=ROUNDING * scale)


def test_sphere_box_cylinder():
    r, h = 0.3, 0.7
    m = 4 / 3 * np.pi * r**3
    same(core.unit_density_mass(core.Sphere(r)), m, np.zeros(3), np.eye(3) * 0.4 * m * r**2)
    a, b, c = 0.2, 0.3, 0.4  # half extents; J = m/12 (full sides squared)
    m = 8 * a * b * c
    box = np.diag([m / 12 * 4 * s for s in (b * b + c * c, a * a + c * c, a * a + b * b)])
    same(core.unit_density_mass(core.Box((a, b, c))), m, np.zeros(3), box)
    m = np.pi * r**2 * 2 * h
    side = m * (3 * r**2 + (2 * h) ** 2) / 12
    cylinder = np.diag([side, side, m * r**2 / 2])
    same(core.unit_density_mass(core.Cylinder(r, h)), m, np.zeros(3), cylinder)


def test_capsule_is_the_integral_over_its_slices():
    r, h = 0.3, 0.7
    # Gauss-Legendre is exact here: every integrand is a polynomial of degree <= 4 on each piece.
    x, w = np.polynomial.legendre.leggauss(8)
    mass, side, axial = 0.0, 0.0, 0.0
    for low, high, radius_sq in (
        (-h, h, lambda z: r**2 + 0 * z),
        (h, h + r, lambda z: r**2 - (z - h) ** 2),
        (-h - r, -h, lambda z: r**2 - (z + h) ** 2),
    ):
        z = (high - low) / 2 * x + (high + low) / 2
        area = np.pi * radius_sq(z)
        weight = (high - low) / 2 * w
        mass += (weight * area).sum()
        axial += (weight * area * radius_sq(z) / 2).sum()
        side += (weight * area * (radius_sq(z) / 4 + z**2)).sum()
    inertia = np.diag([side, side, axial])
    same(core.unit_density_mass(core.Capsule(r, h)), mass, np.zeros(3), inertia)


@pytest.mark.parametrize("seed", range(10))
def test_hull_of_a_placed_box(seed):
    rng = np.random.default_rng(seed)
    half = 10.0 ** rng.uniform(-2, 1, 3)
    turn = oracles.rotation(oracles.random_orientation(rng))
    center = rng.normal(size=3)
    corners = oracles.vertices(core.Box(half)) @ turn.T + center
    mass, _, inertia = core.unit_density_mass(core.Box(half))
    found = core.unit_density_mass(core.ConvexHull(corners))
    same(found, mass, center, turn @ inertia @ turn.T)


def test_tetrahedron_in_closed_form():
    a, b, c = 0.5, 0.4, 0.6  # the corner of a box cut off by a plane
    volume = a * b * c / 6
    center = np.array([a, b, c]) / 4
    # Integrals over the corner tetrahedron: x^2 -> V a^2 / 10, x y -> V a b / 20.
    second = volume / 20 * (np.outer([a, b, c], [a, b, c]) + np.diag([a * a, b * b, c * c]))
    second -= volume * np.outer(center, center)
    inertia = np.trace(second) * np.eye(3) - second
    hull = core.ConvexHull([(0, 0, 0), (a, 0, 0), (0, b, 0), (0, 0, c)])
    same(core.unit_density_mass(hull), volume, center, inertia)


def test_compound_of_two_halves_is_the_whole():
    half = core.Box((0.1, 0.2, 0.15))
    turned = np.array([0, 0, np.sqrt(0.5), np.sqrt(0.5)])
    parts = [
        (core.Box((0.2, 0.1, 0.15)), (0, 0, 0.15), turned),
        (half, (0, 0, -0.15), (0, 0, 0, 1)),
    ]
    found = core.unit_density_mass(core.Compound(parts))
    same(found, *core.unit_density_mass(core.Box((0.1, 0.2, 0.3))))


def test_nested_compounds_are_flattened():
    inner = core.Compound([(core.Sphere(0.1), (1, 0, 0), (0, 0, 0, 1))])
    outer = core.Compound([(inner, (0, 1, 0), (0, 0, 1, 0))])
    ((shape, position, _),) = outer.parts
    assert isinstance(shape, core.Sphere)
    assert position == pytest.approx((-1, 1, 0), abs=1e-15)  # rounding


def test_shapes_without_volume_say_so():
    for shape in (core.Particle(), core.HalfSpace((0, 0, 1), 0.0)):
        with pytest.raises(ValueError, match="no volume"):
            core.unit_density_mass(shape)


@pytest.mark.parametrize("seed", range(20))
def test_principal_inertia(seed):
    rng = np.random.default_rng(seed)
    turn = oracles.rotation(oracles.random_orientation(rng))
    moments = np.sort(10.0 ** rng.uniform(-6, 0, 3))
    inertia = turn @ np.diag(moments) @ turn.T
    found, axes = core.principal_inertia((inertia + inertia.T) / 2)
    assert found == pytest.approx(moments, abs=1e-15 * 4)  # rounding of the largest, about 1
    r = oracles.rotation(axes)
    assert r @ np.diag(found) @ r.T == pytest.approx(inertia, abs=1e-15 * 4)


def test_diagonal_inertia_is_its_own_answer():
    found, axes = core.principal_inertia(np.diag([3.0, 1.0, 2.0]))
    assert found.tolist() == [3.0, 1.0, 2.0]
    assert axes.tolist() == [0, 0, 0, 1]
