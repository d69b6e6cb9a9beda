"""What a robot lacks for the actions of a task."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from handcart.backends.capabilities.battery import Battery
from handcart.backends.capabilities.capability import Capability
from handcart.files.errors import Finding
from handcart.files.yaml.yaml_document import Document
from handcart.networks.graph.network import ActionNetwork, Binding
from handcart.primitives.knowledge.world_model import WorldModel

from .aims_reading import battery_faults


def need_findings(
    document: Document,
    network: ActionNetwork,
    entries: Sequence[int | None],
    kinds: Sequence[type[Capability]],
    model: WorldModel | None,
) -> Iterator[Finding]:
    """Yield a finding for each action that the robot can never do.

    Interrupts that depend on the battery are reported as well if the robot does not measure its charge.

    Args:
        document: the task's file.
        network: its network.
        entries: number in the file of each action of the network; None if the action is generated and only
            skips one element of a `repeat` (a part of the task that is done for each element of a list).
        kinds: classes of the robot's capabilities.
        model: world model before the start; None to check the robot's capabilities alone.
    """
    seen = set[tuple[int, str]]()
    for action, entry in zip(network.actions, entries, strict=True):
        if action.binding is None or entry is None:
            continue
        words = _missing(action.binding, kinds)
        words = words or ("" if model is None else _lacking(action.binding, kinds, model))
        if words and (entry, words) not in seen:
            seen.add((entry, words))
            yield document.finding(("actions", entry, "do"), f"{action.do} {words}")
    if not any(issubclass(kind, Battery) for kind in kinds):
        for path, fault in battery_faults(network.aims):
            yield document.finding(path, fault)


def _missing(binding: Binding, kinds: Sequence[type[Capability]]) -> str:
    """Return the capabilities that a primitive needs and the robot lacks; "" if there are none."""
    needs = binding.kind.needs
    missing = [need.__name__ for need in needs if not any(issubclass(kind, need) for kind in kinds)]
    if not missing:
        return ""
    have = ", ".join(sorted(kind.__name__ for kind in kinds))
    return f"needs what the robot doesn't have: {', '.join(missing)}; it has: {have}"


def _lacking(binding: Binding, kinds: Sequence[type[Capability]], model: WorldModel) -> str:
    """Return what a primitive lacks with its parameters; "" if they are not all known before the start."""
    if binding.late:
        return ""
    primitive = binding.make(model)
    words = primitive.lacking(kinds, model.view(primitive))
    return f"can never be done: {words}" if words else ""
