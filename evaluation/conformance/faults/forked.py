"""Trying something in a copy of this process, which stays as it was."""

from __future__ import annotations

import math
import os
import resource
import select
import signal
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

from handcart.backends.plain_values import from_plain, to_plain
from handcart.backends.saved_state import pack, unpack

T = TypeVar("T")
EGL_PLUGIN = "eglRenderer"
WALL_TIME_RATIO = 10.0  # times as long on the wall as in CPU time: others may load the machine
CPU_LIMIT_RATIO = 0.9  # of that CPU time has passed at its end: the system counts in ticks


class Hung(Exception):
    """Error for a forked copy of the process that did not end in time."""


class Died(Exception):
    """Error for a forked copy of the process that ended in an exception, whose traceback is the message."""


def forked(work: Callable[[], T], kind: type[T], seconds: float) -> T:
    """Run `work` in a forked copy of this process and return its result; side effects are lost.

    The process must have no other threads.

    Args:
        work: function to run.
        kind: type of the function's result, which `plain_values` must support.
        seconds: limit of the copy's CPU time, in [s]; the limit by the wall clock is ten times as long.

    Raises:
        Hung: the copy took longer and was ended.
        Died: the function raised an exception or ended the copy.
    """
    ours, theirs = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(ours)
        _limit(seconds)
        _tell(theirs, work, kind)
    os.close(theirs)
    try:
        received = _listen(ours, time.monotonic() + WALL_TIME_RATIO * seconds)
    except Hung:
        os.kill(child, signal.SIGKILL)
        raise
    finally:
        os.close(ours)
        _, status, used = os.wait4(child, 0)
    if not received:
        if used.ru_utime + used.ru_stime >= CPU_LIMIT_RATIO * seconds:
            raise Hung
        raise Died(f"the process ended with status {status}")
    answer = unpack(received)
    if "died" in answer:
        raise Died(answer["died"])
    result: T = from_plain(answer["value"], kind, "what the copy told")
    return result


@contextmanager
def forkable() -> Iterator[None]:
    """Context in which Bullet creates no threads, because a forked copy of the process would lack them.

    Bullet's EGL renderer has threads; while its plug-in is hidden, Bullet uses a renderer without threads.
    """
    hidden = sys.modules.pop(EGL_PLUGIN, None)
    sys.modules[EGL_PLUGIN] = None  # type: ignore[assignment]
    try:
        yield
    finally:
        del sys.modules[EGL_PLUGIN]
        if hidden is not None:
            sys.modules[EGL_PLUGIN] = hidden


def _limit(seconds: float) -> None:
    """Limit the CPU time of the forked process: the system kills it afterwards."""
    _, most = resource.getrlimit(resource.RLIMIT_CPU)
    limit = math.ceil(seconds) if most == resource.RLIM_INFINITY else min(math.ceil(seconds), most)
    resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))


def _tell(pipe: int, work: Callable[[], object], kind: type) -> None:
    """Work in the forked process, send the result, and exit."""
    try:
        try:
            message = pack({"value": to_plain(work(), kind)})
        except BaseException:
            message = pack({"died": traceback.format_exc()})
        with os.fdopen(pipe, "wb") as stream:
            stream.write(message)
    finally:
        os._exit(0)


def _listen(pipe: int, end: float) -> bytes:
    received = b""
    while True:
        ready, _, _ = select.select([pipe], [], [], max(0.0, end - time.monotonic()))
        if not ready:
            raise Hung
        piece = os.read(pipe, 1 << 16)
        if not piece:
            return received
        received += piece
