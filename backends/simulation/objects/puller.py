"""The person who pulls at an object in the hand."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from handcart.backends.simulation.noise.keyed_noise import keyed, keyed_normal
from handcart.backends.simulation.world.grasp import PAD_FRICTION
from handcart.backends.simulation.world.scene import GRAVITY_M_S2, Scene
from handcart.robotics.geometry.transform import inverse
from handcart.robotics.numerics.arrays import FloatArray

from .pull_spec import PullSpec

OUTSIDE_M = 0.03  # that an object which is held out is beyond the robot's outline
STILL_M = 0.002  # a hand that moves less in a period is at rest
UP_AXIS = np.array([0.0, 0.0, 1.0])
NO_FORCE = np.zeros(3)


class SimulatedPull(NamedTuple):
    """Simulated pull of a person at the held object, with the time at which it began, and whether it is
    over.
    """

    spec: PullSpec
    begun_s: float | None = None
    """Simulated time at which it began; None: not yet."""
    is_over: bool = False


class OfferingHand(NamedTuple):
    """Position in the world, in [m], of a hand that holds an object out, and the time it came to rest."""

    hand: tuple[float, float, float]
    since_s: float


class Puller:
    """Simulated person who pulls at the object in the robot's hand, as a world's file or an injected fault
    states.

    Pulls with `waits_s` begin one after the other, each once the hand has held an object out at rest for
    `waits_s` seconds.
    """

    def __init__(
        self, scene: Scene, seed: int, pulls: Iterable[SimulatedPull], held_out: OfferingHand | None
    ) -> None:
        """Continue with earlier pulls; their progress is in the attributes after each `step`.

        Args:
            scene: true state of the world.
            seed: seed of the pulls' errors.
            pulls: all pulls, with their progress.
            held_out: place of a hand that holds something out; None without one.
        """
        self._scene, self._seed = scene, seed
        self.pulls = list(pulls)
        self.held_out = held_out
        self.force = NO_FORCE
        """Force (3,) of the person on the held object, in the world, in [N]."""

    def step(self) -> None:
        """Begin and end the pulls on the held object that are due in this period. Update `force`, the force
        of the person on the object.
        """
        self._watch_hand()
        now = self._scene.time
        self.pulls = [self._advanced(pull, now) for pull in self.pulls]
        waiting = next((n for n, pull in enumerate(self.pulls) if self._waits(pull)), None)
        if waiting is not None and self.held_out is not None and not any(map(_is_on, self.pulls)):
            pull = self.pulls[waiting]
            assert pull.spec.waits_s is not None
            if now - self.held_out.since_s >= pull.spec.waits_s:
                self.pulls[waiting] = pull._replace(begun_s=now)
        self.force = self._force_now(now)

    def takes(self) -> bool:
        """Return whether the person gets the object if the hand releases it now."""
        return any(_is_on(pull) and pull.spec.takes for pull in self.pulls)

    def released(self) -> None:
        """End all simulated pulls of a person that have begun, because the hand has released the object."""
        self.pulls = [pull._replace(is_over=True) if _is_on(pull) else pull for pull in self.pulls]
        self.force = NO_FORCE

    def tears(self, mass: float, friction: float) -> bool:
        """Return whether the present pull exceeds the friction with which the fingers hold the object.

        Args:
            mass: mass of the held object, in [kg].
            friction: coefficient of friction between fingers and object.
        """
        gripper = self._scene.robot.gripper
        if gripper is None or not self.force.any():
            return False
        load = float(np.linalg.norm(self.force - mass * GRAVITY_M_S2 * UP_AXIS))
        return load > PAD_FRICTION * friction * 2.0 * gripper.force_n

    def _waits(self, pull: SimulatedPull) -> bool:
        return pull.begun_s is None and not pull.is_over and pull.spec.waits_s is not None

    def _advanced(self, pull: SimulatedPull, now: float) -> SimulatedPull:
        """Return a pull as it is at a time: begun if it is time, over after its duration."""
        at = pull.spec.at_s
        if pull.begun_s is None and not pull.is_over and at is not None and now >= at:
            pull = pull._replace(begun_s=now)
        if _is_on(pull) and pull.begun_s is not None and now - pull.begun_s >= pull.spec.duration_s:
            return pull._replace(is_over=True)
        return pull

    def _watch_hand(self) -> None:
        """Note since when the hand holds something out at rest."""
        scene = self._scene
        if scene.held is None:
            self.held_out = None
            return
        at = scene.world_T("hand")[:3, 3]
        x, y, z = at.tolist()
        before = self.held_out
        if before is not None and math.dist(before.hand, (x, y, z)) < STILL_M:
            return
        foot = scene.world_T("hand") @ scene.hand_T_held[:, 3]
        beside = (inverse(scene.world_T_base) @ foot)[None, :2]
        is_outside = float(scene.robot.footprint_shape.distances(beside)[0]) > OUTSIDE_M
        self.held_out = OfferingHand((x, y, z), scene.time) if is_outside else None

    def _force_now(self, now: float) -> FloatArray:
        if self._scene.held is None:
            return NO_FORCE
        forces = [self._of(n, pull, now) for n, pull in enumerate(self.pulls) if _is_on(pull)]
        return np.sum(forces, axis=0) if forces else NO_FORCE

    def _of(self, number: int, pull: SimulatedPull, now: float) -> FloatArray:
        """Return the force (3,) of a pull on the held object now, in the world frame, in [N].

        Args:
            number: index of the pull, which separates its random errors.
            pull: pull that has begun and is not over.
            now: simulated time, in [s].
        """
        spec, rng = pull.spec, keyed(self._seed, f"pull {number}")
        size = max(0.0, spec.force_n + spec.sigma_n * float(rng.standard_normal()))
        turn = Rotation.from_rotvec(math.radians(spec.sigma_deg) * rng.standard_normal(3)).as_matrix()
        assert pull.begun_s is not None
        risen = 1.0 if spec.ramp_s == 0.0 else min(1.0, (now - pull.begun_s) / spec.ramp_s)
        period = round(now / self._scene.robot.period_s)
        tremor = spec.tremor_n * keyed_normal(self._seed, f"tremor of pull {number}", period, 3)
        return np.asarray(size * risen * (turn @ self._direction(spec)) + tremor)

    def _direction(self, spec: PullSpec) -> FloatArray:
        """Return the unit vector (3,) of a pull's nominal direction in the world frame."""
        if spec.direction in ("up", "down"):
            return UP_AXIS if spec.direction == "up" else -UP_AXIS
        out = self._scene.world_T("hand")[:3, 3] - self._scene.world_T_base[:3, 3]
        out[2] = 0.0
        away = out / max(float(np.linalg.norm(out)), 1e-9)
        left = np.cross(UP_AXIS, away)
        return {"away": away, "towards": -away, "left": left, "right": -left}[spec.direction]


def _is_on(pull: SimulatedPull) -> bool:
    return pull.begun_s is not None and not pull.is_over
