"""Newton circled around starts that were near where friction is strong: bodies jammed between planes,
with rolling friction, and two contacts that stop sliding together. The problems (jams.json) are those
of such steps; each has a solution, and steps reported residuals of 2e-8 to 0.6. From the fifth on:
light bodies wedged between heavy ones, where also other starts lead nowhere; the fifth was thrown out
with 3e4 times the energy it came with."""

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


@pytest.mark.parametrize("number", range(len(JAMS)))
@pytest.mark.parametrize("work", [1, 100, 3000])
def test_a_jam_that_is_not_solved_gains_no_energy(number, work):
    arrays = {
        name: np.array(value, np.int32 if name == "bodies" else float)
        for name, value in JAMS[number].items()
    }
    problem = solver.ContactProblem(**arrays)
    settings = solver.SolverSettings()
    settings.max_work = work
    solution, _ = solver.solve_contacts(problem, settings=settings)
    gained = spent = 0.0  # f . (u- + u+) and f . (u+ - u-)
    for i in range(len(arrays["bodies"])):
        before, after = (slip(arrays, i, v) for v in (arrays["velocity"], solution.velocity))
        f = np.concatenate(
            [solution.impulse[i], solution.moment[i] if len(solution.moment) else []]
        )
        gained += f @ (before + after)[: len(f)]
        spent += f @ (after - before)[: len(f)]
    assert gained <= 1e-12 * spent  # the project's bound


def slip(arrays, i, velocity):
    """Relative velocity and spin of contact i, in its frame."""
    (a, b), frame = arrays["bodies"][i], arrays["frame"][i]
    v = velocity[a][:3] + np.cross(velocity[a][3:], arrays["r_a"][i])
    w = velocity[a][3:].copy()
    if b >= 0:
        v -= velocity[b][:3] + np.cross(velocity[b][3:], arrays["r_b"][i])
        w -= velocity[b][3:]
    return np.concatenate([frame @ v + arrays["bias"][i], frame @ w + arrays["angular_bias"][i]])
