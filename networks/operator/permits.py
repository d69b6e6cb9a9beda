"""Permissions for actions: by the operator at a terminal or over a socket, or by a fixed rule."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Literal

from handcart.networks.graph.network import Action

Mode = Literal["ask", "always", "never"]


class Permits:
    """Permissions of the operator, without which the coordinator does not start certain actions.

    The operator is asked before an action with `permit: operator` in the task's file, before an action that
    starts in a situation with a break point, and before every action if the run is stepped. An answer holds
    only for the action that the operator was asked about.
    """

    def __init__(self, mode: Mode = "ask", step: bool = False, breaks: Collection[str] = ()) -> None:
        """Create permits; nothing has been asked yet.

        Args:
            mode: rule for actions with `permit: operator`: the operator is asked, or the answer is always
                yes, or always no; in single steps and at break points the operator is asked all the same.
            step: True to ask the operator before every action.
            breaks: situations before whose actions the operator is asked.
        """
        self.mode = mode
        """Rule for actions with `permit: operator`."""
        self.step = step
        """True if the operator is asked before every action; may change during the run."""
        self._breaks = set(breaks)
        self.asked = 0
        """Number of questions so far, the waiting one included; it is the number of that one."""
        self._asks: Action | None = None
        self._answer: bool | None = None
        self.asking: Callable[[Action], None] = lambda _: None
        """Called once for each question."""
        self.typed: Callable[[], bool | None] = lambda: None
        """Called once a period while an action waits: returns the typed answer, None if nothing was typed."""

    @property
    def asks(self) -> Action | None:
        """The action for whose start the operator is asked now; None if no action waits for an answer."""
        return self._asks

    @property
    def breaks(self) -> Collection[str]:
        """Situations with a break point; the operator is asked before each action that starts in one."""
        return self._breaks

    def break_at(self, situation: str, on: bool) -> None:
        """Set or remove a break point, so that the operator is asked before actions out of a situation.

        Args:
            situation: the situation.
            on: True to set the break point, False to remove it.
        """
        (self._breaks.add if on else self._breaks.discard)(situation)

    def answer(self, permitted: bool) -> None:
        """Permit or refuse the action that waits for an answer; without such an action, do nothing."""
        if self._asks is not None:
            self._answer = permitted

    def withdraw(self) -> None:
        """Withdraw the question, because the run does not wait for its answer any longer."""
        self._asks, self._answer = None, None

    def __call__(self, action: Action) -> bool | None:
        """Return yes, no, or None while no answer has come."""
        if not self._is_asked(action):
            self._asks, self._answer = None, None
            return not (action.permit and self.mode == "never")
        if self._asks is not action:
            self._asks, self._answer = action, None
            self.asked += 1
            self.asking(action)
        if self._answer is None:
            return None
        answer, self._asks, self._answer = self._answer, None, None
        return answer

    def _is_asked(self, action: Action) -> bool:
        return self.step or action.source in self._breaks or (action.permit and self.mode == "ask")
