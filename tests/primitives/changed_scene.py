"""A simulated scene that changes while a primitive runs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from handcart.evaluation.trials.rig import Rig
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.outcomes.outcome import Outcome


def scene_of(rig: Rig) -> Any:
    """The ground truth."""
    return rig.backend.scene  # type: ignore[attr-defined]


def do_when(
    rig: Rig, primitive: ActionPrimitive, once: Callable[[Any], bool], change: Callable[[Any], None]
) -> Outcome:
    """Run a primitive; as soon as `once` holds of the scene, `change` it."""
    scene, step = scene_of(rig), rig.robot.step
    done: list[bool] = []

    def stepping(paused: bool = False) -> None:
        if not done and once(scene):
            done.append(True)
            change(scene)
        step(paused)

    rig.robot.step = stepping  # type: ignore[method-assign]
    outcome = rig.do(primitive)
    assert done
    return outcome
