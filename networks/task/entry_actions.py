"""Actions of the network from entries of a task's file, and what is wrong with an entry."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence

from handcart.files.suggest import suggest
from handcart.files.yaml.yaml_node import KeyPath
from handcart.networks.entries.action_entry import ActionEntry
from handcart.networks.entries.condition_entry import ConditionEntry
from handcart.networks.entries.copied import Copied
from handcart.networks.entries.entry import TaskEntry, listed_names
from handcart.networks.graph.network import Action, Binding, Ending, FailEnding, Situation, faults_of

from .task_model import AnyTaskFile

Faults = Iterator[tuple[KeyPath, str]]
"""Keys in the file, each with the fault there and the allowed values."""
DEFAULT_ATTEMPTS = 3


def action_of(entry: TaskEntry, copied: Copied, binding: Binding, budgets: Mapping[str, int]) -> Action:
    """Return an action of the network, as given by an entry of the task file.

    Args:
        entry: the entry.
        copied: copy of the entry, with the situations that it connects; a `repeat` in the file makes one for
            each element of a list.
        binding: primitive of the action, with its parameters.
        budgets: number of attempts that several actions share, by name.
    """
    limit, others = entry.limit, entry.endings[1:]
    is_shared = limit.shared or isinstance(entry, ConditionEntry)
    unlimited = limit.most == "unlimited"
    most = DEFAULT_ATTEMPTS if limit.most == "unlimited" else limit.most
    return Action(
        copied.source,
        copied.target,
        binding,
        entry.cost_s,
        budgets.get(limit.budget or "", most),
        copied.on_fail,
        permit=needs_permit(entry, binding),
        time_out_s=entry.time_out_s,
        p=entry.endings[0].p if entry.p_success is not None else None,
        p_give_up=entry.p_give_up,
        others=tuple(
            Ending(to, other.result, other.p) for other, to in zip(others, copied.others, strict=True)
        ),
        unlimited=unlimited and limit.budget is None,
        renewals=limit.renewals if limit.fresh_after else 0,
        fresh_after=listed_names(limit.fresh_after),
        budget=limit.budget or (f"{entry.do} {copied.entry}" if is_shared else ""),
        fail_endings=_fail_endings(entry, copied.fails),
    )


def needs_permit(entry: TaskEntry, binding: Binding) -> bool:
    """Return whether an action needs the operator's permission.

    The key `permit` of its entry decides it, or the primitive if the entry has no such key.
    """
    return binding.kind.asks_permission if entry.permit is None else entry.permit == "operator"


def entry_faults(
    entry: ActionEntry, known: Mapping[str, Situation], budgets: Sequence[str], done: Collection[str]
) -> Faults:
    """Yield the faults of an action's entry in a task file, with key paths from the entry on.

    Args:
        entry: the entry.
        known: situations of the file, by name.
        budgets: names of the task's budgets (numbers of attempts that several actions share).
        done: names of all primitives in the file.
    """
    target = entry.endings[0].target
    others = tuple(Ending(ending.target, ending.result, ending.p) for ending in entry.endings[1:])
    fails = _fail_endings(entry, tuple(fail_entry.to for fail_entry in entry.fail_entries.values()))
    plain = Action(
        *(entry.source, target, None, entry.cost_s),
        on_fail=entry.on_fail,
        others=others,
        fail_endings=fails,
    )
    for key, fault in faults_of(plain, known):
        yield ("then" if key == "to" and entry.then else key,), fault
    yield from limit_faults(entry, budgets, done)


def limit_faults(entry: TaskEntry, budgets: Sequence[str], done: Collection[str]) -> Faults:
    """Yield the faults of the numbers of attempts and the probabilities of an action in a task file.

    The key path of a fault begins at the action's entry in the file.

    Args:
        entry: entry of the action in the file.
        budgets: names of the task's budgets.
        done: names of all primitives in the file, to check those that the entry's attempts name.
    """
    yield from _attempt_faults(entry, budgets, done)
    left = 1.0 - (entry.p_success or 0.0)
    if left < -1e-12:
        yield ("then",), f"p of all entries together is {1.0 - left:g}; allowed: at most 1"
    elif entry.p_give_up > left + 1e-12:
        wrong = f"p_give_up is {entry.p_give_up:g}; allowed: at most {left:g}, what p leaves of 1"
        yield ("p_give_up",), wrong
    yield from _cause_faults(entry, left - entry.p_give_up)


def _cause_faults(entry: TaskEntry, left: float) -> Faults:
    """Yield what is wrong with the probabilities of causes; all others share what is `left` of a Fail."""
    every = entry.fail_entries
    if entry.p_success is not None:
        for cause, fail_entry in every.items():
            if fail_entry.p is None:
                yield ("on_fail", cause), f"the Fail by {cause!r} has no p; needed: p, as {entry.do} has one"
    total = sum(fail_entry.p or 0.0 for fail_entry in every.values())
    if total > left + 1e-12:
        wrong = f"p of all causes together is {total:g}; allowed: at most {max(0.0, left):g}, that of a Fail"
        yield ("on_fail",), wrong


def _attempt_faults(entry: TaskEntry, budgets: Sequence[str], done: Collection[str]) -> Faults:
    budget = entry.limit.budget
    if budget is not None and budget not in budgets:
        yield ("attempts", "budget"), f"unknown budget {budget!r}{suggest(budget, budgets)}"
    for name in listed_names(entry.limit.fresh_after):
        if name not in done:
            wrong = f"no action does {name!r}{suggest(name, sorted(done))}"
            yield ("attempts", "fresh_after"), wrong


def chance_faults(file: AnyTaskFile) -> Faults:
    """Yield a fault for each action without a probability, which all policies but `rule` need."""
    for number, entry in enumerate(file.actions):
        if entry.p_success is None:
            wrong = f"{entry.do} has no p, which policy {file.policy!r} needs"
            yield ("actions", number), f"{wrong}; allowed: p, or policy: rule"


def _fail_endings(entry: TaskEntry, nexts: tuple[str | None, ...]) -> tuple[FailEnding, ...]:
    """Return where Fails of named causes lead, given their situations in the network."""
    pairs = zip(entry.fail_entries.items(), nexts, strict=True)
    return tuple(FailEnding(cause, to, item.p) for (cause, item), to in pairs)
