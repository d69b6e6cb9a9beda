"""The life of a run: its states, and their allowed sequences."""

from __future__ import annotations

from enum import Enum
from typing import Any

from transitions import Machine


class RunState(Enum):
    """Present state of a run, for example planning, acting, paused or ended."""

    PLANNING = "planning"
    WAITING_FOR_PERMISSION = "waiting for permission"
    ACTING = "acting"
    RESTORING = "restoring"
    PAUSED_WHILE_ACTING = "paused while acting"
    PAUSED_WHILE_RESTORING = "paused while restoring"
    ENDED = "ended"


_S = RunState
_TRANSITIONS: list[dict[str, Any]] = [
    {"trigger": "_plan", "source": [_S.WAITING_FOR_PERMISSION, _S.ACTING, _S.RESTORING], "dest": _S.PLANNING},
    {"trigger": "_ask", "source": [_S.PLANNING, _S.ACTING, _S.RESTORING], "dest": _S.WAITING_FOR_PERMISSION},
    {"trigger": "_act", "source": [_S.PLANNING, _S.WAITING_FOR_PERMISSION, _S.RESTORING], "dest": _S.ACTING},
    {"trigger": "_restore", "source": _S.ACTING, "dest": _S.RESTORING},
    {"trigger": "_pause", "source": _S.ACTING, "dest": _S.PAUSED_WHILE_ACTING},
    {"trigger": "_pause", "source": _S.RESTORING, "dest": _S.PAUSED_WHILE_RESTORING},
    {"trigger": "_resume", "source": _S.PAUSED_WHILE_ACTING, "dest": _S.ACTING},
    {"trigger": "_resume", "source": _S.PAUSED_WHILE_RESTORING, "dest": _S.RESTORING},
    {"trigger": "_end", "source": [item for item in RunState if item is not _S.ENDED], "dest": _S.ENDED},
]


class RunLife:
    """State machine of a run's present activity (`RunState`), with a method for each transition.

    A transition that the present state does not allow raises `transitions.MachineError`. Entering the
    present state again does nothing; for example, `act` is called again for the next action of a plan.
    """

    def __init__(self) -> None:
        self._state = RunState.PLANNING
        self._machine = Machine(
            model=self,
            states=RunState,
            transitions=_TRANSITIONS,
            initial=RunState.PLANNING,
            auto_transitions=False,
            model_attribute="_state",
        )

    @property
    def state(self) -> RunState:
        """Present state of the run."""
        return self._state

    @property
    def paused(self) -> bool:
        """True during a pause, in which the robot holds and its time does not pass."""
        return self._state in (RunState.PAUSED_WHILE_ACTING, RunState.PAUSED_WHILE_RESTORING)

    def plan(self) -> None:
        """Enter the state of planning, in which the next action is decided."""
        self._go("_plan", RunState.PLANNING)

    def ask(self) -> None:
        """Enter the state in which the run waits for a person's permission to start an action."""
        self._go("_ask", RunState.WAITING_FOR_PERMISSION)

    def act(self) -> None:
        """Enter the state of acting, in which a primitive moves the robot."""
        self._go("_act", RunState.ACTING)

    def restore(self) -> None:
        """Enter the state of restoring, in which a primitive undoes its changes."""
        self._go("_restore", RunState.RESTORING)

    def pause(self) -> None:
        """Enter the state of a pause, in which the robot holds and its time does not pass."""
        self._go("_pause", None)

    def resume(self) -> None:
        """Return to the state that was interrupted by a pause."""
        self._go("_resume", None)

    def end(self) -> None:
        """Enter the final state of the run, from which no other state follows."""
        self._go("_end", RunState.ENDED)

    def _go(self, trigger: str, state: RunState | None) -> None:
        if self._state is not state:
            getattr(self, trigger)()
