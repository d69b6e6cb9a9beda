"""Transports of our nodes: no memory that is shared with other nodes.

By default Fast DDS shares memory with the other nodes of this machine, and mutexes within. A node that is
killed while it holds one stops every node that exchanges messages with it: the control loop of a program
stood still for up to 3 s, and the program crashed when it left the air (see Fast-DDS' issue 5469). Messages
by UDP have no such lock.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

TRANSPORTS, PROFILES = "FASTDDS_BUILTIN_TRANSPORTS", "FASTDDS_DEFAULT_PROFILES_FILE"
RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
CHOICES = (TRANSPORTS, PROFILES, "FASTRTPS_DEFAULT_PROFILES_FILE")
"""Variables by which a user chooses transports; then nothing is changed."""
LOCAL_FILE = Path(__file__).with_name("this_machine.xml")
"""Profile of a node that exchanges messages by UDP, with nodes of this machine only."""
MAPPED_FILE = Path("/proc/self/maps")


def transport_variables(middleware: str) -> Mapping[str, str]:
    """Return environment variables that make a ROS node exchange messages by UDP, not by shared memory.

    Empty if the user has set such variables.

    Args:
        middleware: name of the ROS middleware; the result is empty except for `rmw_fastrtps_cpp` and its
            variants.
    """
    if not middleware.startswith("rmw_fastrtps") or any(os.environ.get(name) for name in CHOICES):
        return {}
    if os.environ.get(RANGE, "").upper() != "LOCALHOST":
        return {TRANSPORTS: "UDPv4"}
    # In this range the middleware adds shared memory itself, whatever the transports are.
    return {RANGE: "SYSTEM_DEFAULT", PROFILES: str(LOCAL_FILE)}


@contextmanager
def environment(variables: Mapping[str, str]) -> Iterator[None]:
    """Set environment variables within this context, and restore the former values at its end."""
    before = {name: os.environ.get(name) for name in variables}
    os.environ.update(variables)
    try:
        yield
    finally:
        for name, content in before.items():
            if content is None:
                del os.environ[name]
            else:
                os.environ[name] = content


def shares_memory(file: Path = MAPPED_FILE) -> bool:
    """Return True if a ROS node of this process uses shared memory, or if that is unknown."""
    try:
        return "/dev/shm/fastdds" in file.read_text(encoding="utf-8")
    except OSError:
        return True
