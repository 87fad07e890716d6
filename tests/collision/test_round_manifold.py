"""Manifolds of cylinders and capsules: on cap, side and rim, along edges, over overhangs."""

import numpy as np
import pytest

from rb_physics import _core as core

IDENTITY = np.array([0.0, 0.0, 0.0, 1.0])
PLANE = core.HalfSpace((0.0, 0.0, 1.0), 0.0)
SLAB = core.Box((2.0, 2.0, 0.5))  # its top at z = 0 when placed at z = -0.5
SLAB_HULL = core.ConvexHull([(x, y, z) for x in (-2, 2) for y in (-2, 2) for z in (-0.5, 0.5)])
GROUNDS = {"plane": (PLANE, 0.0), "box": (SLAB, -0.5), "hull": (SLAB_HULL, -0.5)}
VERTEX_FACE, EDGE_EDGE, EDGE_FACE, FACE_FACE, SMOOTH = range(5)
CYLINDER = core.Cylinder(0.2, 0.3)
CAPSULE = core.Capsule(0.2, 0.3)
ROUNDING = 1e-14  # of lengths of 1 m


def about_y(angle: float) -> np.ndarray:
    return np.array([0, np.sin(angle / 2), 0, np.cos(angle / 2)])


def on(ground, shape, height, orientation, margin=1e-6, x=0.0, y=0.0):
    below, z = GROUNDS[ground]
    return core.find_contacts(
        shape, (x, y, height), orientation, below, (0, 0, z), IDENTITY, margin
    )


@pytest.mark.parametrize("ground", GROUNDS)
def test_cylinder_on_its_cap_stands_on_eight_points_of_the_rim(ground):
    found = on(ground, CYLINDER, 0.3, IDENTITY)
    assert len(found["separation"]) == 8
    assert found["separation"] == pytest.approx(0, abs=ROUNDING)
    assert found["kind"].tolist() == [FACE_FACE] * 8
    assert np.linalg.norm(found["point_a"][:, :2], axis=1) == pytest.approx(0.2, abs=ROUNDING)
    assert found["point_a"].mean(axis=0) == pytest.approx(0, abs=ROUNDING)


@pytest.mark.parametrize("ground", GROUNDS)
@pytest.mark.parametrize("shape", [CYLINDER, CAPSULE], ids=["cylinder", "capsule"])
def test_lying_round_shapes_touch_at_both_ends(ground, shape):
    found = on(ground, shape, 0.2, about_y(np.pi / 2))
    assert sorted(found["point_a"][:, 0]) == pytest.approx([-0.3, 0.3], abs=ROUNDING)
    assert found["separation"] == pytest.approx(0, abs=ROUNDING)
    assert found["kind"].tolist() == [SMOOTH] * 2


@pytest.mark.parametrize("ground", GROUNDS)
def test_cylinder_on_its_rim_touches_in_one_point(ground):
    tilt = 0.4
    height = 0.2 * np.sin(tilt) + 0.3 * np.cos(tilt)
    found = on(ground, CYLINDER, height - 1e-7, about_y(tilt))
    assert found["separation"] == pytest.approx([-1e-7], abs=ROUNDING)
    lowest = (0.2 * np.cos(tilt) - 0.3 * np.sin(tilt), 0, -1e-7)
    assert found["point_a"][0] == pytest.approx(lowest, abs=1e-13)  # rounding, box through EPA


@pytest.mark.parametrize("shape", [CYLINDER, CAPSULE], ids=["cylinder", "capsule"])
@pytest.mark.parametrize("ground", ["box", "hull"])
def test_overhanging_round_shape_touches_up_to_the_edge(ground, shape):
    found = on(ground, shape, 0.2, about_y(np.pi / 2), x=1.9)
    assert sorted(found["point_a"][:, 0]) == pytest.approx([1.6, 2.0], abs=ROUNDING)


@pytest.mark.parametrize("ground", ["box", "hull"])
def test_overhanging_cap_is_cut_by_the_edge(ground):
    found = on(ground, CYLINDER, 0.3, IDENTITY, x=2.0)
    x, y = found["point_a"][:, 0], found["point_a"][:, 1]
    assert (x.min(), x.max()) == pytest.approx((1.8, 2.0), abs=ROUNDING)
    assert (y.min(), y.max()) == pytest.approx((-0.2, 0.2), abs=ROUNDING)


@pytest.mark.parametrize("ground", ["box", "hull"])
def test_box_on_a_cylinder_cap(ground):
    pillar, plate = core.Cylinder(0.5, 0.5), core.Box((0.6, 0.1, 0.1))
    found = core.find_contacts(plate, (0, 0, 0.1), IDENTITY, pillar, (0, 0, -0.5), IDENTITY, 1e-6)
    assert found["normal"] == pytest.approx(np.tile((0, 0, 1), (len(found["kind"]), 1)))
    reach = np.sqrt(0.5**2 - 0.1**2)  # where the plate's long edges leave the disc
    assert found["point_a"][:, 0].max() >= reach - ROUNDING
    assert found["kind"].tolist() == [FACE_FACE] * len(found["kind"])
    assert found["point_a"].mean(axis=0) == pytest.approx((0, 0, 0), abs=ROUNDING)


def test_stacked_cylinders():
    small = core.Cylinder(0.1, 0.1)
    found = core.find_contacts(small, (0, 0, 0.1), IDENTITY, CYLINDER, (0, 0, -0.3), IDENTITY, 1e-6)
    assert len(found["kind"]) == 8
    assert np.linalg.norm(found["point_a"][:, :2], axis=1) == pytest.approx(0.1, abs=ROUNDING)
    lens = core.find_contacts(
        CYLINDER, (0.2, 0, 0.6), IDENTITY, CYLINDER, (0, 0, 0), IDENTITY, 1e-6
    )
    crossing = 0.2 * np.sqrt(3) / 2  # of two circles of radius r at distance r
    assert np.abs(lens["point_a"][:, 1]).max() == pytest.approx(crossing, abs=1e-12)


@pytest.mark.parametrize("shape", [CYLINDER, CAPSULE], ids=["cylinder", "capsule"])
def test_round_shapes_side_by_side_touch_along_the_common_length(shape):
    found = core.find_contacts(shape, (0.4, 0, 0.1), IDENTITY, shape, (0, 0, 0), IDENTITY, 1e-6)
    assert sorted(found["point_a"][:, 2]) == pytest.approx([-0.2, 0.3], abs=ROUNDING)
    assert found["separation"] == pytest.approx(0, abs=ROUNDING)


@pytest.mark.parametrize("shape", [CYLINDER, CAPSULE], ids=["cylinder", "capsule"])
def test_crossed_round_shapes_touch_in_one_point(shape):
    found = core.find_contacts(
        shape, (0, 0, 0.4), about_y(np.pi / 2), shape, (0, 0, 0), (0.5**0.5, 0, 0, 0.5**0.5), 1e-6
    )
    assert found["point_a"] == pytest.approx(np.array([[0, 0, 0.2]]), abs=1e-9)
    assert found["separation"] == pytest.approx([0], abs=ROUNDING)


@pytest.mark.parametrize("ground", ["box", "hull"])
def test_capsule_along_an_edge_has_two_points(ground):
    # Beyond the slab's edge x = 2, z = 0, at 45 degrees above it.
    offset = 0.2 / np.sqrt(2)
    along_y = np.array([np.sqrt(0.5), 0, 0, np.sqrt(0.5)])
    found = on(ground, CAPSULE, offset, along_y, x=2 + offset)
    assert sorted(found["point_b"][:, 1]) == pytest.approx([-0.3, 0.3], abs=ROUNDING)
    assert found["separation"] == pytest.approx(0, abs=ROUNDING)


@pytest.mark.parametrize("ground", GROUNDS)
@pytest.mark.parametrize("shape", [CYLINDER, CAPSULE], ids=["cylinder", "capsule"])
def test_ids_survive_rounding(ground, shape):
    for orientation in (IDENTITY, about_y(np.pi / 2)):
        height = 0.2 if orientation is not IDENTITY else shape.half_length
        if shape is CAPSULE and orientation is IDENTITY:
            height += 0.2
        exact = on(ground, shape, height, orientation)
        for seed in range(10):
            noise = np.random.default_rng(seed).uniform(-1e-15, 1e-15, 5)
            q = orientation + np.append(noise[:3], 0)
            near = on(ground, shape, height + noise[3], q, x=noise[4])
            assert sorted(near["feature"]) == sorted(exact["feature"])
            assert near["kind"].tolist() == exact["kind"].tolist()


@pytest.mark.parametrize("seed", range(30))
def test_concentric_bodies_part(seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(6, 3)) * 0.2
    hull = core.ConvexHull(np.vstack([points, -points]))
    shapes = [core.Sphere(0.2), core.Box((0.1, 0.2, 0.3)), CAPSULE, CYLINDER, hull, core.Particle()]
    turn = rng.normal(size=4) if seed else IDENTITY
    turn = turn / np.linalg.norm(turn)
    for a in shapes:
        for b in shapes:
            found = core.find_contacts(a, (0, 0, 0), turn, b, (0, 0, 0), IDENTITY, 0.0)
            again = core.find_contacts(a, (0, 0, 0), turn, b, (0, 0, 0), IDENTITY, 0.0)
            assert len(found["kind"]) >= 1
            assert all(np.isfinite(found[k]).all() for k in found)
            assert all((found[k] == again[k]).all() for k in found)
            assert np.linalg.norm(found["normal"], axis=1) == pytest.approx(1, abs=ROUNDING)
