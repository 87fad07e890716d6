"""The accuracy table's cases at other sizes, masses, attitudes, places, speeds and steps.

Targets are those of the table (relative, so that they hold at every scale). A stage far from the
origin cannot do better than the rounding of its coordinates; where that shows, it says so.
"""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks import accuracy_cases as cases
from benchmarks.stage import Stage, multiply, turn

TILTED = tuple(multiply(turn((1, 2, 3), 1.1), turn((0, 1, 0), 0.4)))
CEILING = turn((1, 0, 0), np.pi)  # gravity points up
STAGES = {
    "as_written": Stage(),
    "tilted": Stage(attitude=TILTED),
    "upside_down": Stage(attitude=tuple(CEILING)),
    "hundred_times_larger": Stage(size=100.0),
    "thousand_times_smaller": Stage(size=1e-3),
    "heavy": Stage(mass=1e4),
    "light": Stage(mass=1e-4),
    "coarse_dt": Stage(dt_factor=4.0),
    "fine_dt": Stage(dt_factor=0.37),
    "on_a_lift": Stage(boost=(0.3, -0.2, 1.0)),
    "away_from_the_origin": Stage(origin=(20.0, -30.0, 5.0), attitude=TILTED),
    "all_at_once": Stage(
        attitude=TILTED, size=0.03, mass=20.0, dt_factor=2.0, origin=(1.0, 2.0, 3.0)
    ),
}
everywhere = pytest.mark.parametrize("stage", STAGES.values(), ids=STAGES)
# `event` is for reference, and slower: fewer stages.
PLAYED = {f"fixed-{name}": stage for name, stage in STAGES.items()} | {
    f"event-{name}": replace(STAGES[name], stepper="event")
    for name in ("as_written", "coarse_dt", "on_a_lift", "all_at_once")
}
everywhere_both_ways = pytest.mark.parametrize("stage", PLAYED.values(), ids=PLAYED)


def judge(figures: dict[str, float], **limits: float) -> None:
    """Every named figure within its limit, and every solve within the residual and energy rules."""
    limits = {"residual": 1e-8, "energy gain": 1e-12, **limits}
    bad = {n: figures[n] for n, most in limits.items() if not figures[n] <= most}
    assert not bad, f"{bad} of {figures}"


@pytest.mark.parametrize("dt", [1e-3, 1e-2])
@pytest.mark.parametrize(
    ("moments", "spin"),
    [((1, 2, 3), (0.01, 5.0, 0.01)), ((0.5, 0.6, 1.0), (0.3, 2.0, 1.0)), ((2, 3, 4.9), (0, 1, 4))],
)
def test_free_body(moments, spin, dt):
    figures = cases.free_body(Stage(), dt, 20.0, moments, spin)
    # Rounding of up to 20000 steps, a random walk of 1e-16 each.
    assert figures["energy"] <= 1e-13
    assert figures["L"] <= 1e-14
    assert figures["attitude (rad)"] <= 1e-9


@everywhere_both_ways
@pytest.mark.parametrize("restitution", [0.8, 0.55])
def test_bouncing_ball(stage, restitution):
    seconds = 5.0 if restitution == 0.8 else 1.6
    figures = cases.bouncing_ball(stage, restitution, 1e-3, seconds)
    # On a lift the floor's place is summed up step by step; coordinates of 1 to 5 m round to 1e-15.
    moving = np.any(stage.boost) or np.any(stage.origin)
    limit = 1e-10 if moving else 1e-12 if stage.stepper == "event" else 1e-6
    judge(figures, apex=limit)


@everywhere_both_ways
def test_elastic_ball(stage):
    figures = cases.elastic_ball(stage, seconds=4.0)
    judge(figures, **{"energy": 1e-10, "above the start": 1e-10 if np.any(stage.boost) else 1e-12})


@everywhere_both_ways
@pytest.mark.parametrize(("balls", "struck"), [(5, 1), (5, 2), (3, 1), (8, 3), (2, 1)])
def test_newtons_cradle(stage, balls, struck):
    figures = cases.newtons_cradle(stage, balls, struck=struck)
    # 1e-12 of the speed, plus what the coordinates round to: neighbours touch to 1e-15 / 0.1.
    judge(figures, velocities=1e-12 if not np.any(stage.origin) else 1e-10)


@everywhere_both_ways
@pytest.mark.parametrize("law", ["sequential", "simultaneous", "reflections"])
@pytest.mark.parametrize(
    ("friction", "restitution"), [(0.3, 0.6), (1.5, 0.6), (0.0, 1.0), (0.4, 0.0)]
)
def test_oblique_bounce(stage, law, friction, restitution):
    figures = cases.oblique_bounce(replace(stage, impact_law=law), friction, restitution)
    # Arms are differences of coordinates: 30 m rounds to 4e-15, of an arm of 0.1 m 4e-14.
    judge(figures, velocity=1e-12, spin=1e-12)


@everywhere_both_ways
@pytest.mark.parametrize("fraction", [0.9, 0.99])
@pytest.mark.parametrize(
    ("friction", "heading", "on_box"), [(0.5, 0.0, False), (1.2, 0.7, False), (0.3, 2.0, True)]
)
def test_box_on_incline_stays(stage, fraction, friction, heading, on_box):
    figures = cases.box_on_incline(stage, fraction, friction, 1e-3, 0.4, heading, on_box)
    judge(figures, **{"creep (m/s)": 1e-12 * max(1.0, 30 * np.linalg.norm(stage.boost))})


@everywhere_both_ways
@pytest.mark.parametrize("fraction", [1.01, 1.1])
@pytest.mark.parametrize(
    ("friction", "heading", "on_box"), [(0.5, 0.0, False), (0.9, 0.7, False), (0.3, 2.0, True)]
)
def test_box_down_incline_slides(stage, fraction, friction, heading, on_box):
    figures = cases.box_down_incline(stage, fraction, friction, 1e-3, 1.0, heading, on_box)
    judge(figures, distance=1e-6, velocity=1e-6)


@everywhere_both_ways
@pytest.mark.parametrize(
    ("heading", "friction", "speed", "on_box"),
    [(0.0, 0.4, 2.0, False), (np.pi / 6, 0.4, 2.0, False), (2.0, 0.15, 0.7, True)],
)
def test_box_slides_to_rest(stage, heading, friction, speed, on_box):
    figures = cases.box_slides_to_rest(stage, heading, friction, speed, on_box=on_box)
    # Far out the coordinates round to 4e-15 of a path of some centimetres or more.
    judge(figures, **{"distance": 1e-6, "off (deg)": 1e-9 if not np.any(stage.origin) else 1e-8})


@everywhere_both_ways
@pytest.mark.parametrize(
    ("heading", "friction", "spin", "ratio"),
    [(0.0, 0.3, (0, 0, 0), 0.4), (0.5, 0.1, (5, -3, 20), 0.4), (1.0, 0.8, (0, -30, 0), 2 / 3)],
)
def test_sphere_starts_to_roll(stage, heading, friction, spin, ratio):
    figures = cases.sphere_starts_to_roll(stage, heading, friction, 2.0, 1e-3, spin, ratio)
    # The arm, 0.1 m or smaller, is a difference of coordinates of up to 30 m.
    limit = 1e-12 if not np.any(stage.origin) else 1e-11
    judge(figures, velocity=limit, slip=limit, distance=1e-6)


@everywhere
@pytest.mark.parametrize(
    "tower",
    [
        {"boxes": 10},
        {"boxes": 4, "half": (0.1, 0.15, 0.05), "on_box": True},
        {"boxes": 5, "masses": (1.0, 1e2, 3.0, 0.1, 10.0)},
    ],
    ids=["ten", "flat_on_a_box", "masses"],
)
def test_tower(stage, tower):
    figures = cases.tower(stage, seconds=1.0, **tower)
    even = len(set(tower.get("masses", [1]))) == 1
    judge(
        figures,
        **{
            "penetration (m)": 1e-9,
            # With unequal masses the lightest load is 1e-3 of the heaviest: 1e-12 of that one.
            "force sum": 1e-12 if even else 1e-9,
            "corners": 1e-9 if even else 1e-6,
            "jitter (N)": 1e-9 if even else 1e-6,
            "residual": 1e-12,
        },
    )


@pytest.mark.parametrize("friction", [0.0, 0.2, 2.0])
def test_tower_whatever_its_friction(friction):
    figures = cases.tower(Stage(), 6, seconds=0.5, friction=friction)
    judge(figures, **{"penetration (m)": 1e-9, "force sum": 1e-12, "corners": 1e-9})


@pytest.mark.parametrize("ratio", [1e2, 1e3, 1e4])
@pytest.mark.parametrize("heavy_above", [False, True])
def test_tower_of_two_masses(ratio, heavy_above):
    masses = (1.0, ratio) if heavy_above else (ratio, 1.0)
    figures = cases.tower(Stage(), 2, seconds=1.0, masses=masses)
    # Loads are judged one by one: the light one may carry the heavy one's rounding.
    judge(figures, **{"penetration (m)": 1e-9, "force sum": 1e-12 * ratio, "motion (m/s)": 1e-9})


def test_tower_of_thirty():
    figures = cases.tower(Stage(), 30, seconds=2.0)
    judge(figures, **{"penetration (m)": 1e-6, "motion (m/s)": 1e-6, "residual": 1e-12})


@everywhere_both_ways
@pytest.mark.parametrize("angle", [np.pi / 4, 0.3, 1.1])
def test_sphere_in_groove(stage, angle):
    figures = cases.sphere_in_groove(stage, angle, steps=60, heading=0.3)
    judge(figures, **{"N": 1e-10, "balance": 1e-10, "moved (m)": 1e-10})


@everywhere_both_ways
@pytest.mark.parametrize(
    ("friction", "angle"),
    [(0.0, np.pi / 4), (0.3, np.pi / 4), (0.9, np.pi / 4), (0.2, 0.5), (0.0, 0.3)],
)
def test_box_in_groove(stage, friction, angle):
    figures = cases.box_in_groove(stage, friction, steps=60, heading=0.4, angle=angle)
    judge(
        figures,
        **dict.fromkeys(("N", "balance", "mirror", "outside the cone", "moved (m)"), 1e-10),
    )


@pytest.mark.parametrize("stagger", [0.0, 0.02])
def test_heap_of_balls(stagger):
    figures = cases.heap_of_balls(Stage(), seconds=2.0, side=4, stagger=stagger)
    judge(figures, **{"squared penetration (m²)": 1e-10})


@pytest.mark.soak
@pytest.mark.parametrize("stagger", [0.0, 0.02])
def test_666(stagger):
    judge(cases.heap_of_balls(Stage(), stagger=stagger), **{"squared penetration (m²)": 1e-10})


def test_the_table_itself_is_judged():
    """A figure that falls short, a NaN or an exception is marked and makes `make verify` fail."""
    from benchmarks.accuracy import ROWS, Result, lines_of

    row = ROWS[2]
    good = {"apex": 1e-7, "residual": 0.0, "energy gain": 0.0}
    assert Result(row, "fixed", good, 0.0).short() == []
    assert Result(row, "event", good, 0.0).short() == ["apex"]
    assert Result(row, "fixed", {**good, "apex": float("nan")}, 0.0).short() == ["apex"]
    assert Result(row, "fixed", {**good, "residual": 1e-7}, 0.0).short() == ["residual"]
    assert Result(row, "fixed", {}, 0.0, "RuntimeError: no").short() == ["error"]
    assert "FALLS SHORT" in "\n".join(lines_of(Result(row, "event", good, 0.0)))
