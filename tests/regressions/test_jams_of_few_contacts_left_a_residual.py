"""Newton circled around starts that were near where friction is strong: bodies jammed between planes,
with rolling friction, and two contacts that stop sliding together. The problems (jams.json) are those
of such steps; each has a solution, and steps reported residuals of 2e-8 to 0.6."""

import json
from pathlib import Path

import numpy as np
import pytest

from rb_physics._core import solver

JAMS = json.loads((Path(__file__).parent / "jams.json").read_text())


@pytest.mark.parametrize("number", range(len(JAMS)))
def test_jam(number):
    arrays = {
        name: np.array(value, np.int32 if name == "bodies" else float)
        for name, value in JAMS[number].items()
    }
    problem = solver.ContactProblem(**arrays)
    solution, _ = solver.solve_contacts(problem)
    # Rounding of slips that are 1e-8 of the speeds they are the difference of.
    assert solver.natural_map_residual(problem, solution) <= 1e-10
