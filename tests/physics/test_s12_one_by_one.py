"""S12: several contacts, one after the other: cheap, order dependent, ends when none approaches."""

import numpy as np
import pytest
from wedge import particle_in_wedge

from benchmarks.stage import Stage, turn


@pytest.mark.parametrize("attitude", [(0, 0, 0, 1), tuple(turn((1, 1, 0), 0.9))])
def test_wedge_ends_with_no_contact_approaching(attitude):
    """The order shows in the answer: both are legal, they differ."""
    answers = []
    for first in (0, 1):
        stage = Stage(impact_law="sequential", attitude=attitude)
        world, ball, normals = particle_in_wedge(stage, order=(first, 1 - first))
        world.step()
        v = stage.velocity(ball)
        # Conditions of S14 that the sequence keeps: nothing approaches, no energy is gained.
        assert min(n @ v for n in normals) > -1e-9
        assert np.linalg.norm(v) <= 1 + 1e-12
        answers.append(v)
    # Energy is kept by each elastic impact, so both leave at full speed.
    np.testing.assert_allclose(np.linalg.norm(answers, axis=1), 1, atol=1e-12)
    assert np.linalg.norm(answers[0] - answers[1]) > 1e-3


def test_a_row_of_balls_passes_the_blow_on():
    """Struck in the order of the row, the sequence is Newton's cradle."""
    from benchmarks.accuracy_cases import newtons_cradle

    stage = Stage(settings={"impact_law": "sequential"})
    assert newtons_cradle(stage)["velocities"] <= 1e-12
