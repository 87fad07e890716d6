"""Makes `benchmarks` importable, and marks what is known to fall short.

Tests and the accuracy table play the same cases (`benchmarks/accuracy_cases.py`).
"""

import re
import sys
from pathlib import Path

import pytest

ROOT = str(Path(__file__).resolve().parents[2])
if ROOT not in sys.path:
    sys.path.append(ROOT)  # last: an installed build stays first

# Test (a regular expression for its name) -> what falls short. Not strict: some of these fail on
# one platform's rounding and pass on another's. Take a line out when its cause is gone.
KNOWN_SHORTFALLS = {
    r"test_tower\[": "jitter of 1.6e-9 N at some scales; under a boost 1e-7 N, force sums 1e-10",
    r"test_box_in_groove\[0.[39]-0.785.*on_a_lift\]": "under a boost the first forces are not the least",
    r"test_invariance\[.*(50-|mirror)": "sliding boxes have more than one answer; which one is found"
    " depends on the order of the contacts",
    r"test_(oblique_bounce|sphere_starts_to_roll)\[.*event-all_at_once\]": "1e-11 in `event`",
    r"test_box_slides_to_rest\[.*on_a_lift\]": "residual 1.01e-8 where 1e-8 is asked, under a boost",
    r"test_clusters_of_balls": "one cluster of 8 balls ends at a residual of 1.4e-8",
    r"test_painleves_rod": "slow, and overlaps where the rod jams",
}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    here = Path(__file__).parent
    for item in items:
        if here not in item.path.parents:
            continue
        for pattern, reason in KNOWN_SHORTFALLS.items():
            if re.match(pattern, item.name):
                item.add_marker(pytest.mark.xfail(reason=reason, strict=False))
