"""Commands of the operator to a run, and the run's answers."""

from __future__ import annotations

from collections import deque
from pathlib import Path
from types import TracebackType
from typing import Any

from typing_extensions import override

from handcart.backends.robot.robot import Robot
from handcart.files.printable import clipped, printable
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.coordination.run_life import RunState
from handcart.networks.coordination.supervision import Request
from handcart.networks.events.run_observer import RunObserver
from handcart.networks.graph.network import Action

from .control import Control
from .message import KEYS_BY_WORD, REQUEST_BY_WORD, Message, fault_of
from .permits import Permits

_IDLE = (RunState.WAITING_FOR_PERMISSION, RunState.PAUSED_WHILE_ACTING, RunState.PAUSED_WHILE_RESTORING)
MAX_LISTED_COMMANDS = 20
"""Number of the latest commands that the status lists."""
_KEPT = 1000  # nonces
DEFAULT_SENDER = "the terminal"


class Operation(RunObserver):
    """Server of the operator's commands to a run, polled once a period until the run has ended.

    While the run waits for a permission or is paused, polling waits up to one control period for a command,
    because nothing else has to be computed. It is a context manager, which closes the sockets at its end.
    """

    def __init__(self, folder: Path, coordinator: Coordinator, permits: Permits, robot: Robot) -> None:
        self._coordinator, self._permits, self._robot = coordinator, permits, robot
        self._heard = _Heard()
        self._control = Control(folder, self.answer, self._stop)

    def look(self) -> None:
        """Receive and execute the operator's commands to the run; called once a period."""
        if self._coordinator.asks is None:
            self._permits.withdraw()
        idle = self._coordinator.life.state in _IDLE
        self._control.poll(self._robot.period if idle else 0.0)
        answer = self._permits.typed() if self._permits.asks is not None else None
        if answer is not None:
            self._permits.answer(answer)

    @override
    def period(self, robot: Robot) -> None:
        self.look()

    def answer(self, message: Message) -> dict[str, Any]:
        """Execute a message's command, unless it was received before, and return the run's status.

        The answer to an invalid or refused command contains the reason instead.
        """
        wrong = fault_of(message, self._coordinator.network.situations)
        if wrong or self._heard.again(message):
            return _refused(wrong) if wrong else {"ok": True, "again": True, **self.status()}
        match str(message["do"]):
            case "permit" | "refuse" as word:
                wrong = self._permit(word == "permit", message)
            case "step":
                self._permits.step = message.get("on", True)
            case "break":
                self._permits.break_at(message["at"], message.get("on", True))
            case "status":
                pass
            case word:
                wrong = self._coordinator.ask(REQUEST_BY_WORD[word], message.get("number"))
        if wrong:
            return _refused(wrong)
        self._heard.note(message, self._robot.time)
        return {"ok": True, **self.status()}

    def status(self) -> dict[str, Any]:
        """Return the state of the run (activity, situation, actions, open question, break points) as fields
        of an answer.
        """
        asks = self._permits.asks
        question = None if asks is None else {**_words(asks), "ask": self._permits.asked}
        return {
            "state": self._coordinator.life.state.value,
            "situation": self._coordinator.situation,
            "actions": self._coordinator.running,
            "acting": self._coordinator.acting,
            "unapplied": list(self._coordinator.unapplied),
            "sim_time_s": round(self._robot.time, 3),
            "asks": question,
            "step": self._permits.step,
            "breaks": sorted(self._permits.breaks),
            "commands": self._heard.latest(),
        }

    def _stop(self) -> None:
        self._coordinator.request(Request.STOP)
        self._heard.note({"do": "stop"}, self._robot.time)

    def _permit(self, permitted: bool, message: Message) -> str:
        asks, number, ask = self._permits.asks, message.get("action"), message.get("ask")
        if asks is None:
            return "no action waits for permission"
        if number is not None and number != asks.index:
            return f"action {number} doesn't wait for permission; waiting is {asks.index}: {asks}"
        if ask is not None and ask != self._permits.asked:
            return f"question {ask} is over; waiting is question {self._permits.asked}: {asks}"
        self._permits.answer(permitted)
        return ""

    def __enter__(self) -> Operation:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._control.close()


class _Heard:
    """Log of the last commands: command, sender, time."""

    def __init__(self) -> None:
        """Create an empty log."""
        self._commands: deque[dict[str, Any]] = deque(maxlen=MAX_LISTED_COMMANDS)
        self._nonces: deque[str] = deque(maxlen=_KEPT)
        self._count = 0

    def again(self, message: Message) -> bool:
        """Return whether the same message was received before, by its nonce (row U7)."""
        return message.get("nonce") in self._nonces

    def note(self, message: Message, time: float) -> None:
        """Keep a command that was done at a time, in [s] of the robot's."""
        if "nonce" in message:
            self._nonces.append(message["nonce"])
        if message["do"] == "status":
            return
        self._count += 1
        more = {key: message[key] for key in KEYS_BY_WORD.get(message["do"], ()) if key in message}
        by = printable(clipped(str(message.get("by") or DEFAULT_SENDER)))
        said = {"number": self._count, "do": message["do"], **more, "by": by}
        self._commands.append({**said, "sim_time_s": round(time, 3)})

    def latest(self) -> list[dict[str, Any]]:
        """Return the last commands, the oldest first."""
        return list(self._commands)


def _refused(wrong: str) -> dict[str, Any]:
    return {"ok": False, "error": wrong}


def _words(action: Action) -> dict[str, Any]:
    given = {} if action.binding is None else action.binding.given()
    words = {"index": action.index, "do": action.do, "from": action.source, "to": action.target}
    return {**words, "with": {name: _value(value) for name, value in given.items()}}


def _value(value: Any) -> str:
    """Return a parameter in words; for one bound to the world model, the name of the entry."""
    late = isinstance(value, dict) and value.keys() == {"model"}
    return clipped(str(value["model"] if late else value))
