"""Findings on actions of a task that can never start, because of the hand's content at that time."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from typing import NamedTuple

from handcart.files.errors import Finding
from handcart.networks.graph.network import Action, Binding
from handcart.networks.task.preparing import nowhere
from handcart.networks.task.task_file import Task
from handcart.primitives.knowledge.world_model import WorldModel
from handcart.primitives.preconditions.hand_use import Hand, HandUse

from .hand_facts import hand_by_facts


class Held(NamedTuple):
    """Content of the hand in a situation, with the reason why it is known."""

    hand: Hand
    """EMPTY, FULL or ANY; ANY: not known."""
    thing: str = ""
    """Name of the held object; empty if none or any is held."""
    why: str = ""
    """Reason in words: the fact or the action that implies it."""

    def __str__(self) -> str:
        what = "is empty" if self.hand is Hand.EMPTY else f"holds {self.thing or 'something'}"
        return f"the hand {what} ({self.why})"


class _Use(NamedTuple):
    """Requirement of one action on the hand, and the hand's content after its Success."""

    use: HandUse
    thing: str


def hand_findings(task: Task) -> list[Finding]:
    """Return findings on actions whose precondition on the hand never holds, whichever route a run takes.

    The content of the hand follows from the facts of the situations, and from the declarations of the
    primitives of earlier actions.

    Args:
        task: the task, whose network has a copy of each repeated part for each element.
    """
    uses = _uses(task)
    reached = _reached(task, uses)
    found: dict[int, Finding] = {}
    for action, entry in zip(task.network.actions, task.entries, strict=True):
        if entry is None or action.index not in uses or entry in found:
            continue
        unmet = [_unmet(uses[action.index], held) for held in reached.get(action.source, ())]
        if unmet and all(unmet):
            words = f"{action.do} can't start in {action.source!r}: {unmet[0]}"
            allowed = "allowed: an action before it that sees to that"
            found[entry] = task.document.finding(("actions", entry, "from"), f"{words}; {allowed}")
    return list(found.values())


def denied_hand_facts(task: Task) -> list[Finding]:
    """Return findings on actions whose file states facts that contradict the hand's content after the action.

    A fact is stated for the situation to which the action leads. Whether the hand is then full or empty is
    declared by the action's primitive.
    """
    uses = _uses(task)
    found: dict[int, Finding] = {}
    for action, entry in zip(task.network.actions, task.entries, strict=True):
        if (
            entry is not None
            and action.index in uses
            and (words := _denied(task, action, uses[action.index]))
        ):
            message = f"{words}; allowed: facts that agree with it"
            found.setdefault(entry, task.document.finding(("actions", entry, "to"), message))
    return list(found.values())


def _uses(task: Task) -> dict[int, _Use]:
    """Return the hand use of each action that runs a primitive, by the action's number."""
    known = task.knowledge
    model = WorldModel(nowhere(), known.all_places(), sections=known.fresh_sections())
    return {action.index: _use_of(action.binding, model) for action in task.network.actions if action.binding}


def _use_of(binding: Binding, model: WorldModel) -> _Use:
    if binding.late:  # its parameters are known in the run
        return _Use(binding.kind.usual_hand_use(), "")
    primitive = binding.kind.model_validate(binding.fixed)
    use = primitive.hand_use()
    return _Use(use, primitive.thing(model.view(primitive)) if Hand.FULL in use else "")


def _reached(task: Task, uses: dict[int, _Use]) -> dict[str, list[Held]]:
    """Return the possible contents of the hand in each situation that a run can reach."""
    network = task.network
    leaving: dict[str, list[Action]] = {}
    for action in network.actions:
        leaving.setdefault(action.source, []).append(action)
    start = Held(*_by_facts(task, network.start))
    reached: dict[str, list[Held]] = {network.start: [start]}
    waiting = deque([(network.start, start)])
    while waiting:
        situation, held = waiting.popleft()
        for action in leaving.get(situation, ()):
            for target, then in _follow(task, action, uses.get(action.index), held):
                known = reached.setdefault(target, [])
                if not any(item[:2] == then[:2] for item in known):
                    known.append(then)
                    waiting.append((target, then))
    return reached


def _follow(task: Task, action: Action, use: _Use | None, held: Held) -> Iterator[tuple[str, Held]]:
    """Yield the situations after an action, with the possible content of the hand there."""
    then = held if use is None else _after(task, action, use, held)
    for target, state in ((action.target, then), *((to, held) for to in action.fail_situations)):
        yield target, _agreed(state, Held(*_by_facts(task, target)))


def _agreed(state: Held, said: Held) -> Held:
    """Return the content of the hand by earlier actions and by facts; ANY if these contradict each other."""
    if said.hand is Hand.ANY or said.hand is state.hand:
        return state
    return said if state.hand is Hand.ANY else Held(Hand.ANY)


def _after(task: Task, action: Action, use: _Use, held: Held) -> Held:
    if use.use.after is Hand.SAME:  # one that can't start is reported once, not what follows from it
        return Held(Hand.ANY) if _unmet(use, held) else held
    entry = task.entries[action.index]
    line = "" if entry is None else f", line {task.document.position(('actions', entry))[0]}"
    return Held(use.use.after, use.thing if use.use.after is Hand.FULL else "", f"after {action.do}{line}")


def _unmet(use: _Use, held: Held) -> str:
    """Return why an action cannot start, in words; empty if it can."""
    needed = use.use.before
    if needed is Hand.ANY or held.hand is Hand.ANY:
        return ""
    if needed is not held.hand:
        wants = "an empty hand" if needed is Hand.EMPTY else f"{use.thing or 'something'} in the hand"
        return f"it needs {wants}, and {held}"
    if use.thing and held.thing and use.thing != held.thing:
        return f"it needs {use.thing} in the hand, and {held}"
    return ""


def _denied(task: Task, action: Action, use: _Use) -> str:
    """Return how an action's effect on the hand contradicts the facts of its target; empty if it does not."""
    hand, _, said = _by_facts(task, action.target)
    after = use.use.after
    if after in (Hand.EMPTY, Hand.FULL) and hand is not Hand.ANY and hand is not after:
        leaves = "empty" if after is Hand.EMPTY else f"with {use.thing or 'something'} in it"
        return f"{action.do} leaves the hand {leaves}, but {action.target!r} says {said!r}"
    return ""


def _by_facts(task: Task, situation: str) -> tuple[Hand, str, str]:
    hand, said = hand_by_facts(task.network.situations[situation].facts)
    return hand, "", said
