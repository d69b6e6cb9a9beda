"""Detection of header stamps that cannot be the times of their messages."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import BoolArray, FloatArray

JUMP_S = 1.0  # allowed change between stamp and receive time from one message to the next
JUMP_SPREADS = 10.0  # the same in median changes: a bag may have been replayed slowly or in bursts
NEIGHBOUR_COUNT = 5  # messages on either side that decide whether a jump lasts
APART_S = 2.0  # between the clocks of two topics: more cannot be a delay
LATE_S = 0.2  # between two topics, from which a delay is reported
MAX_WRONG = 0.5  # share of a topic's stamps: with more they are unusable


class StampReport(NamedTuple):
    """Result of checking a topic's header stamps: a mask of those that can be used, messages about tolerable
    faults, and the reason if none can be used.
    """

    used: BoolArray
    """(n,) mask of messages with a credible stamp."""
    notes: list[str]
    """Messages about tolerable faults."""
    unusable: str
    """Reason why the stamps cannot be used; empty if they can."""


def check_stamps(topic: str, stamps: FloatArray, received: FloatArray) -> StampReport:
    """Compare the header stamps of a topic with the times at which its messages were recorded.

    Args:
        topic: name of the topic, for the messages.
        stamps: (n,) header stamps in [s], in the order of recording.
        received: (n,) times of recording, in [s].
    """
    count, zero = len(stamps), stamps == 0.0
    used, notes = ~zero, list[str]()
    if zero.mean() > MAX_WRONG:
        share = "all" if zero.all() else f"{int(zero.sum())} of {count}"
        return StampReport(used, notes, f"{topic}: {share} stamps are zero ({count} messages)")
    if zero.any():
        notes.append(_left_out(topic, "are zero", zero, received))
    wrong = used & _alone(stamps, received, used)
    if wrong.any():
        notes.append(_left_out(topic, "are off alone", wrong, received))
        used &= ~wrong
    rows = np.flatnonzero(used)
    jumps = _jumps(stamps[rows], received[rows])
    if len(jumps):
        first, size = jumps[0]
        after = received[rows[first]] - received[0]
        times = "" if len(jumps) == 1 else f", and {len(jumps) - 1} times more"
        words = f"{topic}: stamps jump by {size:+.1f} s after {after:.1f} s{times}"
        return StampReport(used, notes, words)
    steps = np.diff(stamps[rows])
    back, again = steps < 0.0, steps == 0.0
    if back.any():
        at = received[rows[int(np.argmax(back)) + 1]] - received[0]
        most = -float(steps.min())
        notes.append(
            f"{topic}: {int(back.sum())} stamps fall back, first after {at:.1f} s, by {most:.3f} s at most; "
            "played in the order of the stamps"
        )
    if again.any():
        at = received[rows[int(np.argmax(again)) + 1]] - received[0]
        notes.append(f"{topic}: {int(again.sum())} stamps repeat the one before, first after {at:.1f} s")
    return StampReport(used, notes, "")


def check_offsets(delays: dict[str, float]) -> tuple[list[str], str]:
    """Compare the clocks by which the messages of several topics were stamped.

    Args:
        delays: median time from stamp to recording for each topic, in [s].

    Returns:
        Notes about a topic whose messages arrive late, and the reason why the stamps cannot be used together;
        both are empty without a problem.
    """
    if len(delays) < 2:
        return [], ""
    least = min(delays, key=lambda topic: delays[topic])
    most = max(delays, key=lambda topic: delays[topic])
    apart = delays[most] - delays[least]
    words = f"stamps of {most} are {apart:.2f} s older when they are recorded than those of {least}"
    if apart > APART_S:
        return [], f"{words}: two clocks"
    return ([f"{words}: it comes late, or has another clock"], "") if apart > LATE_S else ([], "")


def _left_out(topic: str, what: str, wrong: BoolArray, received: FloatArray) -> str:
    after = received[int(np.argmax(wrong))] - received[0]
    return (
        f"{topic}: {int(wrong.sum())} stamps {what}, first after {after:.1f} s; those messages are left out"
    )


def _limit(parts: FloatArray) -> float:
    """Return the difference from which two clocks count as diverged, in [s], by the changes (n,) of their
    offset in [s].
    """
    return max(JUMP_S, JUMP_SPREADS * float(np.median(np.abs(parts)))) if len(parts) else JUMP_S


def _alone(stamps: FloatArray, received: FloatArray, used: BoolArray) -> BoolArray:
    """Return a mask (n,) of stamps that differ while their neighbours agree with each other.

    Args:
        stamps: (n,) header stamps, in [s].
        received: (n,) times of recording, in [s].
        used: (n,) True for stamps that are considered.
    """
    rows = np.flatnonzero(used)
    found = np.zeros(len(stamps), dtype=bool)
    if len(rows) < 2 * NEIGHBOUR_COUNT:
        return found
    offsets = (stamps - received)[rows]
    padded = np.pad(offsets, 2, mode="edge")
    usual = np.median(np.lib.stride_tricks.sliding_window_view(padded, 5), axis=1)
    found[rows] = np.abs(offsets - usual) > _limit(np.diff(usual))
    return found


def _jumps(stamps: FloatArray, received: FloatArray) -> list[tuple[int, float]]:
    """Return the index of each lasting jump of stamps (n,) against receive times (n,), with its size, all in
    [s].
    """
    offsets = stamps - received
    parts = np.diff(offsets)
    limit = _limit(parts)
    found = []
    for k in np.flatnonzero(np.abs(parts) > limit) + 1:
        before = float(np.median(offsets[max(0, k - NEIGHBOUR_COUNT) : k]))
        after = float(np.median(offsets[k : k + NEIGHBOUR_COUNT]))
        if abs(after - before) > limit and (parts[k - 1] > 0.0 or stamps[k] < stamps[k - 1]):
            found.append((int(k), after - before))
    return found
