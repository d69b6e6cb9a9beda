"""Things that lean on the robot, which must not sleep."""

from __future__ import annotations

from typing import Any

import numpy as np

from handcart.robotics.numerics.arrays import BoolArray

from .mujoco_module import mujoco

_NO_ISLAND = -2


class Leaning:
    """Selector of the resting bodies that MuJoCo must not put to sleep (the robot and things that lean on
    it).

    MuJoCo does not simulate bodies that sleep. A sleeping thing that leans on the robot would not fall when
    the robot drives away, so it is kept awake; other things sleep when they come to rest.
    """

    def __init__(self) -> None:
        """Begin without a model."""
        self._robot: int | None = None
        """Number of the robot's kinematic tree in the model; None without a robot."""
        self.trees = np.zeros(0, np.bool_)
        """Mask (trees,) of the kinematic trees of things that touch the robot, directly or through others."""
        self._seen = b""
        """Contact islands of the trees at the last call of `look`, as bytes."""

    def compiled(self, model: Any, link: int | None) -> None:
        """Adapt the record of things that lean on the robot to a newly compiled model.

        The model may have more kinematic trees than the model before.

        Args:
            model: MuJoCo's model.
            link: MuJoCo's number of one of the robot's links; None without a robot.
        """
        leaned, self.trees = self.trees, np.zeros(int(model.ntree), np.bool_)
        self._robot = None if link is None else int(model.body_treeid[link])
        if self._robot is not None:
            self.set(model, np.pad(leaned, (0, len(self.trees) - len(leaned))))

    def look(self, model: Any, data: Any) -> None:
        """Update the set of movable things that are in contact with the robot, directly or through other
        things.

        To be called after the solver has made steps. `model` and `data` are MuJoCo's.
        """
        if self._robot is None:
            return
        island = data.tree_island
        seen = island.tobytes()
        if seen == self._seen:
            return
        mine = island[self._robot]
        leans = island == (mine if mine >= 0 else _NO_ISLAND)
        if (leans != self.trees).any():
            self.set(model, leans)
        self._seen = seen

    def set(self, model: Any, leans: BoolArray) -> None:
        """Keep the kinematic trees in `leans` and the robot awake, and let all others sleep when they come to
        rest.

        Args:
            model: MuJoCo's model.
            leans: (trees,) mask of the kinematic trees that stay awake.
        """
        kinds, policy = mujoco().mjtSleepPolicy, model.tree_sleep_policy
        policy[self.trees] = kinds.mjSLEEP_ALLOWED
        policy[leans] = kinds.mjSLEEP_NEVER
        policy[self._robot] = kinds.mjSLEEP_NEVER
        self.trees, self._seen = leans, b""
