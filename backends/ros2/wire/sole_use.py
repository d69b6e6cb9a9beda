"""One program of this machine at a time that commands a robot."""

from __future__ import annotations

import fcntl
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from handcart.files.state_folder import state_folder

from .ros_errors import NotOnTheAir

_FLAGS = os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW


@contextmanager
def sole_use(robot: str) -> Iterator[None]:
    """Context in which this program alone commands a robot, as far as this machine is concerned.

    Nodes discover each other only within seconds, and a run that is under way would take a second node on its
    command topics for a rival. Where the lock's folder cannot be used, only the nodes are looked for.

    Args:
        robot: domain and namespace of the robot's topics.

    Raises:
        NotOnTheAir: another program commands the robot; the error names its process.
    """
    folder = state_folder() / "commanding"
    file = -1
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        file = os.open(folder / re.sub(r"[^\w.-]", "_", robot), _FLAGS, 0o600)
    if file < 0:
        yield
        return
    try:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            process = os.pread(file, 20, 0).decode(errors="replace").strip()
            words = f"process {process} of this machine commands the robot in {robot}"
            raise NotOnTheAir([f"{words}; allowed: one run at a time"]) from None
        os.ftruncate(file, 0)
        os.pwrite(file, str(os.getpid()).encode(), 0)
        yield
    finally:
        os.close(file)
