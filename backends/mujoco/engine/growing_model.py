"""MuJoCo's model of a world that grows, and its data."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .mujoco_module import mujoco
from .world_spec import WorldSpec

_KEPT = ("actuator_gainprm", "actuator_biasprm", "actuator_forcerange")
"""Arrays of a model that control its drives."""


class GrowingModel:
    """MuJoCo model of a world to which bodies can be added during a run.

    The model is compiled on first use, and again after additions; the poses and speeds of existing bodies
    stay as they are.
    """

    def __init__(self, step: float, compiled: Callable[[Any], None]) -> None:
        """Create a world whose solver has steps of that length, in [s]; `compiled` receives each new
        model.
        """
        self.world = WorldSpec(step)
        self._compiled: tuple[Any, Any] | None = None
        self._tell, self._grown, self._stale = compiled, True, True

    def both(self) -> tuple[Any, Any]:
        """Return MuJoCo's model (`MjModel`) and its data (`MjData`, the state); compile both if needed.

        Poses of links in the data may be outdated; the method `links` updates them.
        """
        if self._grown or self._compiled is None:
            return self._compile()
        return self._compiled

    def changed(self) -> None:
        """Mark the model as outdated after a change of `world`; the next use compiles it again."""
        self._grown = True

    def links(self) -> Any:
        """Return MuJoCo's `MjData` (the state of the model), with the current poses of all links."""
        model, data = self.both()
        if self._stale:
            mujoco().mj_kinematics(model, data)
            self._stale = False
        return data

    def displaced(self) -> None:
        """Mark all bodies' poses as outdated after a joint was set; the next call of the method `links`
        computes them from the joints.
        """
        self._stale = True

    def forget(self) -> None:
        """Discard the compiled model and its data."""
        self._compiled, self._grown = None, True

    def _compile(self) -> tuple[Any, Any]:
        before = self._compiled
        if before is None:
            model = self.world.spec.compile()
            made = model, mujoco().MjData(model)
        else:
            made = self.world.spec.recompile(*before)
            for name in _KEPT:
                old, new = getattr(before[0], name), getattr(made[0], name)
                if old.shape == new.shape:
                    new[:] = old
        self._compiled, self._grown, self._stale = made, False, True
        self._tell(made[0])
        return made
