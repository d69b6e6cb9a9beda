"""The actions of a running run, in the form in which its journal records them."""

from __future__ import annotations

from dataclasses import replace

from typing_extensions import override

from handcart.networks.events.events import Ended, Event, Restoring, Started
from handcart.networks.events.run_observer import RunObserver
from handcart.networks.journal.run_log import outcome_record

from .past_run import PastAction


class ActionLog(RunObserver):
    """Observer that collects the actions of a run, with their outcomes, as they start and end."""

    def __init__(self) -> None:
        """Create an empty log."""
        self.actions: list[PastAction] = []
        """Actions so far, in the order in which they were started."""

    @override
    def event(self, event: Event) -> None:
        time = round(event.time, 6)  # as the journal keeps it
        match event:
            case Started(_, number, action, primitive):
                words = primitive.model_dump(mode="json")
                names = (action.do, action.source, action.target)
                self.actions.append(PastAction(number, action.index, *names, words, time, time, None, ""))
            case Restoring():
                self._change(end=time, broken_off=time)
            case Ended(_, number, _, _, outcome):
                result = {"kind": "RESULT", "t": time, **outcome_record(number, outcome)}
                self._change(end=time, outcome=type(outcome).__name__, result=result)
            case _:
                if self.actions and not self.actions[-1].outcome:
                    self._change(end=time)

    def _change(self, **fields: object) -> None:
        self.actions[-1] = replace(self.actions[-1], **fields)  # type: ignore[arg-type]
