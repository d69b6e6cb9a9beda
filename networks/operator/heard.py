"""What was asked of a run, so that everybody sees it, and nothing is done twice."""

from __future__ import annotations

from collections import deque
from typing import Any

from handcart.files.printable import clipped, printable

from .message import KEYS, Message

SHOWN = 20
"""Of the last commands, how many are told."""
_KEPT = 1000  # nonces
NOBODY = "the terminal"


class Heard:
    """The last commands: what, by whom, when."""

    def __init__(self) -> None:
        """Nothing was said yet."""
        self._commands: deque[dict[str, Any]] = deque(maxlen=SHOWN)
        self._nonces: deque[str] = deque(maxlen=_KEPT)
        self._count = 0

    def again(self, message: Message) -> bool:
        """Whether the same message was heard before, by its nonce (row U7)."""
        return message.get("nonce") in self._nonces

    def note(self, message: Message, time: float) -> None:
        """Keep a command that was done at a time, in [s] of the robot's."""
        if "nonce" in message:
            self._nonces.append(message["nonce"])
        if message["do"] == "status":
            return
        self._count += 1
        more = {key: message[key] for key in KEYS.get(message["do"], ()) if key in message}
        by = printable(clipped(str(message.get("by") or NOBODY)))
        said = {"number": self._count, "do": message["do"], **more, "by": by}
        self._commands.append({**said, "sim_time_s": round(time, 3)})

    def told(self) -> list[dict[str, Any]]:
        """The last ones, the oldest first."""
        return list(self._commands)
