"""rb_physics beside the engines a Python or ROS user could pick instead, on the same scenes in the same run.

``python -m benchmarks.engines`` prints the table and writes ``benchmarks/RESULTS.md``. An engine that
is not installed is named and left out. Every engine runs in a process of its own, all pinned to one
core, blocks of steps taking turns; penetration is measured by ``penetration.py`` from poses alone.
"""
