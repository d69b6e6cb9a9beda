"""The operator's services of a run, through the same sockets as those of all other programs."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from handcart.backends.ros2.wire.serving_link import Answer, ServingLink
from handcart.files.errors import HandcartError
from handcart.networks.operator.asking import ask, tell_to_stop

SERVICE_PREFIX = "handcart"
SENDER_NAME = "ROS"
COMMAND_WORDS = ("pause", "continue", "cancel", "restore", "permit", "refuse")
STOP_TIMEOUT_S = 10.0
"""Time within which a run has to end after a stop, in [s]."""
ANSWER_TIMEOUT_S = 2.0
EFFECT_TIMEOUT_S = 1.0
"""Time within which a pause, or its end, has to appear in the status, in [s]."""
PAUSED_STATUS = "paused"
STATUS_PERIOD_S = 0.02
NEW_QUESTION_S = 1.0
"""Time in [s] for which a new question cannot be answered, because a Trigger does not name its question."""


class Door:
    """ROS services through which an operator commands one run, as with `handcart console`.

    The run itself decides whether it obeys.
    """

    def __init__(
        self, folder: Path, ended: threading.Event, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Serve a run.

        Args:
            folder: the run's folder.
            ended: set once the run has ended.
            clock: gives a time in [s].
        """
        self._folder, self._ended, self._clock = folder, ended, clock
        self._question: tuple[int | None, float] = (None, 0.0)
        self.outcome = ""
        """Outcome of the run, in words."""

    def offer(self, link: ServingLink) -> None:
        """Offer a ROS service for each command by which an operator intervenes in the run, and one that stops
        the run.
        """
        for word in COMMAND_WORDS:
            link.serve(f"{SERVICE_PREFIX}/{word}", lambda word=word: self._command(word))  # type: ignore[misc]
        link.serve(f"{SERVICE_PREFIX}/stop", self._stop, apart=True)

    def status(self) -> dict[str, Any]:
        """Return the status of the run; it has the key `error` if the run does not answer."""
        try:
            status = ask(self._folder, {"do": "status", "by": SENDER_NAME}, ANSWER_TIMEOUT_S)
        except HandcartError as error:
            return {"state": "does not answer", "error": str(error)}
        self.published(status)
        return {key: value for key, value in status.items() if key != "ok"}

    def published(self, status: Mapping[str, Any]) -> None:
        """Remember which question to the operator a published status contains, and since when.

        Services only answer this question, and only after it has been published for `NEW_QUESTION_S`.
        """
        asks = status.get("asks")
        number = None if not asks else int(asks["ask"])
        if number != self._question[0]:
            self._question = number, self._clock()

    def _command(self, word: str) -> Answer:
        message: dict[str, Any] = {"do": word, "by": SENDER_NAME}
        if word in ("permit", "refuse"):
            number, since = self._question
            if number is None:
                return Answer(False, "no action waits for permission")
            if self._clock() - since < NEW_QUESTION_S:
                return Answer(
                    False, f"question {number} is new; read it in {SERVICE_PREFIX}/status, and call again"
                )
            message["ask"] = number
        try:
            reply = ask(self._folder, message, ANSWER_TIMEOUT_S)
        except HandcartError as error:
            return Answer(False, str(error))
        if not reply["ok"]:
            return Answer(False, str(reply["error"]))
        return self._effect(word, reply)

    def _effect(self, word: str, reply: Mapping[str, Any]) -> Answer:
        """Wait until the run has paused, or continues; success only then."""
        wanted = {"pause": True, "continue": False}.get(word)
        end = self._clock() + EFFECT_TIMEOUT_S
        while True:
            state = str(reply["state"])
            words = f"{state} in {reply['situation']}"
            if wanted is None or state.startswith(PAUSED_STATUS) == wanted:
                return Answer(True, words)
            if self._ended.wait(STATUS_PERIOD_S):
                return Answer(False, self.outcome)
            if self._clock() > end:
                return Answer(False, f"accepted, but it is still {words}")
            try:
                reply = ask(self._folder, {"do": "status", "by": SENDER_NAME}, ANSWER_TIMEOUT_S)
            except HandcartError as error:
                return Answer(False, str(error))

    def _stop(self) -> Answer:
        """Stop the run, and answer once it has ended."""
        try:
            tell_to_stop(self._folder)
        except HandcartError as error:
            return Answer(False, str(error))
        if not self._ended.wait(STOP_TIMEOUT_S):
            return Answer(False, f"the run has not ended within {STOP_TIMEOUT_S:g} s; use the emergency stop")
        return Answer(True, self.outcome)
