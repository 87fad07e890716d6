"""Cylinders whose caps are parallel to 1e-8: distances were wrong by more than 1e-9 of the size."""

import numpy as np
import pytest

from rb_physics import _core as core
from tests import oracles


def test_two_cylinders_meeting_rim_to_rim():
    """Between the two caps' normals lies one that parts them; GJK had run into rounding."""
    a = core.Cylinder(128.6713656961155, 54.90551750972814)
    b = core.Cylinder(278.9974279329166, 244.37535283519756)
    q = (-6.180600322843484e-09, -2.133763423785948e-09, 1.0, 3.1853503025351035e-09)
    pose_a = (np.array((2.014565979744253, 288.4719022446329, -299.28087169519574)), np.array(q))
    pose_b = (np.zeros(3), np.array((0.0, 0.0, 0.0, 1.0)))
    n = np.array((3.52987885e-09, 7.06682765e-09, -1.0))
    along = oracles.separation_along(a, pose_a, b, pose_b, n / np.linalg.norm(n))
    assert core.distance(a, *pose_a, b, *pose_b)[0] >= along - 1e-10 * a.radius


def test_the_lowest_point_of_a_cap_over_a_face_is_kept():
    """It was thinned out as one of many; the far cap's rim was kept instead."""
    a = core.Cylinder(0.0003539077548202787, 8.649253776025406e-05)
    b = core.Box((0.0008737401137603637, 0.0002567249376015558, 0.000788138429769329))
    pose_a = (np.array((-0.00027644, -0.00061345, -0.00046639)), np.array((-0.5, 0.5, 0.5, 0.5)))
    pose_b = (
        np.zeros(3),
        np.array((6.44419876e-09, -2.68081195e-09, 1.0, -7.20001131e-09)),
    )
    d, _, _, n = core.distance(a, *pose_a, b, *pose_b)
    along = oracles.separation_along(a, pose_a, b, pose_b, n)
    assert d == pytest.approx(along, abs=2e-10 * a.radius)
    found = core.find_contacts(a, *pose_a, b, *pose_b, 1.0)
    assert (found["separation"] <= d + 1e-6 * a.radius).all()  # all of the near cap
