"""A ROS domain that no other run on this machine uses meanwhile."""

from __future__ import annotations

import fcntl
import os
import tempfile
from pathlib import Path
from typing import IO

DOMAINS = range(1, 100)  # their ports lie below those that Linux hands out to anybody
_held: list[IO[str]] = []  # locks, kept until the process ends


def use_own_domain() -> int:
    """Sets ROS_DOMAIN_ID, on this machine only, for this process and those it starts; the number.

    Neither hears other robots nor disturbs them. Raises OSError when all are in use.
    """
    folder = Path(tempfile.gettempdir()) / "rb_physics_test_domains"
    folder.mkdir(exist_ok=True)
    for k in range(len(DOMAINS)):
        number = DOMAINS[(os.getpid() + k) % len(DOMAINS)]
        try:
            lock = open(folder / str(number), "w")  # noqa: SIM115 (held for the life of the process)
        except OSError:  # somebody else's file
            continue
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            lock.close()
            continue
        _held.append(lock)
        os.environ["ROS_DOMAIN_ID"] = str(number)
        os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
        return number
    raise OSError(f"every ROS_DOMAIN_ID of {DOMAINS} is in use; {folder} holds the locks")
