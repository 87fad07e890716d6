"""Polytopes about to touch, or one 5000 times the other: the distance came out too great by 1e-7 of the smaller."""

from tests.collision import test_pair_fuzz as fuzz


def test_unequal_boxes():
    for seed in (10070, 15144):
        fuzz.check_pair(("box", "box"), seed)


def test_box_and_hull_a_hair_apart():
    fuzz.check_pair(("box", "hull"), 6662)
