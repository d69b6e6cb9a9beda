"""Planned faults between a robot and this program."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from handcart.files.errors import InputError
from handcart.files.suggest import suggest

OLD_STAMP_S = 60
ACTION_KINDS = ("rejects", "aborts", "cancels", "unanswered")
FAULT_KINDS = {
    "silent": "no message of the topic is sent any more",
    "frozen": "the last message is sent again and again",
    "delayed": "each message is sent 0.5 s later",
    "doubled": "each message is sent twice",
    "swapped": "each two messages are sent in the wrong order",
    "old-stamps": f"stamps are {OLD_STAMP_S} s old",
    "nan": "the first number of each message is NaN",
    "wrong-frame": "messages come from another frame",
    "rejects": "an action rejects each goal",
    "aborts": "an action aborts each goal",
    "cancels": "an action cancels each goal by itself",
    "unanswered": "an action answers no goal",
}
DELAY_S = 0.5
PICTURE_KIND = "sensor_msgs/Image"


class TopicFault(NamedTuple):
    """A fault that a simulated robot injects into the messages of one topic, or into an action."""

    kind: str
    """One of `FAULT_KINDS`."""
    topic: str
    at_s: float
    """Time of the bench from which the fault is present, in [s]."""

    @classmethod
    def read(cls, words: str) -> TopicFault:
        """Parse a fault from `KIND@TOPIC@SECONDS`; without `@SECONDS` the fault is present from the start.

        Raises:
            InputError: the text is not of this form, or KIND is not one of `FAULT_KINDS`.
        """
        kind, _, rest = words.partition("@")
        topic, _, at = rest.partition("@")
        if kind not in FAULT_KINDS:
            raise InputError(f"{kind!r} is not a fault of a topic{suggest(kind, list(FAULT_KINDS))}")
        try:
            at_s = float(at or "0")
        except ValueError:
            at_s = math.nan
        if not topic or not math.isfinite(at_s):
            raise InputError(f"{words!r} is not a fault; allowed: KIND@TOPIC@SECONDS")
        return cls(kind, topic, at_s)


class BenchFaults:
    """Planned faults of a simulated robot's topics and actions.

    A fault changes the messages of its topic from its planned time on.
    """

    def __init__(self, period: float, planned: tuple[TopicFault, ...] = ()) -> None:
        """Plan faults; `period` is the time between two messages, in [s]."""
        self._planned, self._periods = planned, max(1, round(DELAY_S / period))
        self._kept: dict[TopicFault, list[Any]] = {}

    @property
    def any_planned(self) -> bool:
        """True if any faults are planned; a driver's messages may then be changed or held back."""
        return bool(self._planned)

    def add(self, fault: TopicFault) -> None:
        """Add a fault to the planned faults of the simulated robot's topics and actions."""
        self._planned = (*self._planned, fault)

    def check(self, topics: Mapping[str, str], actions: Sequence[str]) -> None:
        """Raise `InputError` if a planned fault has no effect, because the bench has no such topic or action,
        or its messages have no number that can be NaN.

        Args:
            topics: topics that the bench publishes, each with the type of its messages.
            actions: names of the actions that it serves.
        """
        for fault in self._planned:
            what, names = ("an action", actions) if fault.kind in ACTION_KINDS else ("a topic", topics)
            if fault.topic not in names:
                hint = suggest(fault.topic, list(names))
                raise InputError(f"fault {fault.kind!r}: {fault.topic!r} is not {what} of this bench{hint}")
            if fault.kind == "nan" and topics[fault.topic] == PICTURE_KIND:
                raise InputError(f"fault 'nan' has no effect on pictures, such as {fault.topic!r}")

    def is_due(self, kind: str, name: str, now_s: float) -> bool:
        """Return True if a planned fault of a topic or action has begun.

        Args:
            kind: kind of the fault, one of `FAULT_KINDS`.
            name: name of the topic or action.
            now_s: time of the bench, in [s].
        """
        return any(pair.kind == kind and pair.topic == name and now_s >= pair.at_s for pair in self._planned)

    def passed(self, topic: str, message: Any, now_s: float) -> list[Any]:
        """Return the messages that are sent instead of a driver's message, because of the planned faults of
        its topic.

        Planned faults that have begun by `now_s` are applied; without a fault the list holds the message
        itself.

        Args:
            topic: name of the topic.
            message: message of a driver; a fault may change it in place.
            now_s: time of the bench, in [s].
        """
        sent = [message]
        for fault in self._planned:
            if fault.topic == topic and now_s >= fault.at_s and fault.kind not in ACTION_KINDS:
                sent = [item for one in sent for item in self._changed(fault, one)]
        return sent

    def _changed(self, fault: TopicFault, message: Any) -> Iterator[Any]:
        kept = self._kept.setdefault(fault, [])
        match fault.kind:
            case "silent":
                return
            case "frozen":
                kept.append(message)
                yield kept[0]
            case "delayed":
                kept.append(message)
                if len(kept) > self._periods:
                    yield kept.pop(0)
            case "doubled":
                yield from (message, message)
            case "swapped":
                kept.append(message)
                if len(kept) == 2:
                    yield from (kept[1], kept[0])
                    kept.clear()
            case "old-stamps":
                for header in _headers(message):
                    header.stamp.sec -= OLD_STAMP_S
                yield message
            case "nan":
                _spoil(message)
                yield message
            case _:
                for header in _headers(message):
                    header.frame_id = "nowhere"
                yield message


def _headers(message: Any) -> list[Any]:
    if hasattr(message, "transforms"):
        return [transform.header for transform in message.transforms]
    return [message.header]


def _spoil(message: Any) -> None:
    """Put NaN into the first number that a message measures."""
    if hasattr(message, "transforms"):
        message.transforms[0].transform.translation.x = math.nan
    elif hasattr(message, "pose"):
        message.pose.pose.position.x = math.nan
    elif hasattr(message, "position"):
        message.position[0] = math.nan
    elif hasattr(message, "angular_velocity"):
        message.angular_velocity.x = math.nan
    elif hasattr(message, "angle_increment"):
        message.angle_increment = math.nan
    elif hasattr(message, "latitude"):
        message.latitude = math.nan
    elif hasattr(message, "k"):
        message.k[0] = math.nan
