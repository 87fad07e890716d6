"""A step of 25 or 40 boxes took longer than one of 4000: corrections asked loaded contacts for what
they contradict each other in, eight times a step, and pivoted on rows that depend on each other one
by one.
"""

import numpy as np
import pytest

from benchmarks.engines.engine_rb_physics import RbPhysics
from benchmarks.engines.scenes import pile


@pytest.mark.parametrize("boxes", [17, 25, 40])
def test_piles_settle_in_few_corrections_and_sweeps(boxes):
    world = RbPhysics(pile(boxes)).world
    corrections, iterations = [], []
    for _ in range(30):
        world.step()
        corrections.append(world.stats.corrections)
        iterations.append(world.stats.iterations)
        assert world.stats.residual <= 1e-3  # of a pile that moves
    # What is in contact overlaps by less than the touch distance of such a box, 1e-10 m.
    assert world.stats.max_penetration <= 1e-10
    assert max(corrections) <= 3  # 8 before
    assert np.median(iterations) <= 330  # two looks of 160 sweeps, or Newton's method


def test_a_pile_comes_to_rest_and_carries_its_weight():
    world = RbPhysics(pile(25)).world
    world.step(600)
    assert world.stats.residual <= 1e-12  # what rests is solved directly
    contacts = world.contacts
    floor = [k for k, b in enumerate(world.bodies) if b.type == "static"]
    on_floor = contacts["force"][np.isin(contacts["body_b"], floor), 2]
    weight = 9.81 * sum(b.mass for b in world.bodies if b.type == "dynamic")
    assert on_floor.sum() == pytest.approx(weight, rel=1e-10)  # sums of 25 bodies' balances
