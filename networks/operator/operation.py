"""The operator in command of a run: what may be asked of it, and how it answers."""

from __future__ import annotations

from pathlib import Path
from types import TracebackType
from typing import Any

from handcart.backends.robot.robot import Robot
from handcart.files.printable import clipped, printable
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.coordination.run_life import RunState
from handcart.networks.coordination.supervision import Request
from handcart.networks.graph.network import Action
from handcart.networks.run_observer import RunObserver

from .control import Control, Message
from .permits import Permits

REQUESTS = {
    "pause": Request.PAUSE,
    "continue": Request.RESUME,
    "stop": Request.STOP,
    "cancel": Request.CANCEL,
    "restore": Request.RESTORE,
}
WORDS = (*REQUESTS, "permit", "refuse", "status")
_IDLE = (RunState.WAITING_FOR_PERMISSION, RunState.PAUSED_WHILE_ACTING, RunState.PAUSED_WHILE_RESTORING)


class Operation(RunObserver):
    """Listens in the run's folder while the run lives; asked once a period.

    While the run waits for a permission or is paused, a period lasts as long on the wall clock: there is
    nothing to compute, and nobody should have to hurry. A context manager.
    """

    def __init__(self, folder: Path, coordinator: Coordinator, permits: Permits, robot: Robot) -> None:
        self._coordinator, self._permits, self._robot = coordinator, permits, robot
        self._control = Control(folder, self.answer, lambda: coordinator.request(Request.STOP))

    def look(self) -> None:
        """Once a period: hear who has something to say."""
        idle = self._coordinator.life.state in _IDLE
        self._control.poll(self._robot.period if idle else 0.0)
        answer = self._permits.typed() if self._permits.asks is not None else None
        if answer is not None:
            self._permits.answer(answer)

    def period(self, robot: Robot) -> None:
        """See `RunObserver`."""
        self.look()

    def answer(self, message: Message) -> dict[str, Any]:
        """Do what a message asks for, and tell how things stand."""
        word, wrong = str(message.get("do")), _wrong(message)
        if not wrong and word in ("permit", "refuse"):
            wrong = self._permit(word == "permit", message.get("action"))
        elif not wrong and word != "status" and not self._coordinator.request(REQUESTS[word]):
            wrong = "too much is asked for at once; allowed: to wait until it is done, and to stop"
        return {"ok": False, "error": wrong} if wrong else {"ok": True, **self.status()}

    def status(self) -> dict[str, Any]:
        """How things stand."""
        asks = self._permits.asks
        return {
            "state": self._coordinator.life.state.value,
            "situation": self._coordinator.situation,
            "actions": self._coordinator.running,
            "sim_time_s": round(self._robot.time, 3),
            "asks": None if asks is None else _words(asks),
        }

    def _permit(self, permitted: bool, number: object) -> str:
        asks = self._permits.asks
        if asks is None:
            return "no action waits for permission"
        if number is not None and number != asks.index:
            return f"action {number} doesn't wait for permission; what waits is {asks.index}: {asks}"
        self._permits.answer(permitted)
        return ""

    def __enter__(self) -> Operation:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._control.close()


def _wrong(message: Message) -> str:
    """What makes a message none, "what is wrong; what is allowed"; nothing where it is one.

    A stop is one whatever else it says.
    """
    word = message.get("do")
    if word == "stop":
        return ""
    if not isinstance(word, str) or word not in WORDS:
        wrong = f"unknown word {_shown(word)}" if "do" in message else "the key 'do' is missing"
        return f"{wrong}; allowed: {', '.join(WORDS)}"
    known = {"do", "action"} if word in ("permit", "refuse") else {"do"}
    if unknown := message.keys() - known:
        return f"unknown key {_shown(min(unknown))}; allowed: {', '.join(sorted(known))}"
    number = message.get("action")
    if number is not None and (isinstance(number, bool) or not isinstance(number, int)):
        return f"the action {_shown(number)} is no number; allowed: an action's number"
    return ""


def _shown(value: object) -> str:
    return printable(clipped(repr(value)))


def _words(action: Action) -> dict[str, Any]:
    return {"index": action.index, "do": action.do, "from": action.source, "to": action.target}
