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

# Test (a regular expression for its name) -> what falls short. Strict: take a line out when its
# cause is gone.
KNOWN_SHORTFALLS = {
    r"test_painleves_rod\[1-0.8-2.0-fixed": "2.5e-6 J come in where the jammed rod sticks",
}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    here = Path(__file__).parent
    for item in items:
        if here not in item.path.parents:
            continue
        for pattern, reason in KNOWN_SHORTFALLS.items():
            if re.match(pattern, item.name):
                item.add_marker(pytest.mark.xfail(reason=reason, strict=True))
