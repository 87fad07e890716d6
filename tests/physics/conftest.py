"""Makes `benchmarks` importable: tests and the accuracy table play the same cases
(`benchmarks/accuracy_cases`)."""

import sys
from pathlib import Path

ROOT = str(Path(__file__).resolve().parents[2])
if ROOT not in sys.path:
    sys.path.append(ROOT)  # last: an installed build stays first
