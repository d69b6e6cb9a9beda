"""The arm among solid things."""

from __future__ import annotations

import numpy as np

from handcart.backends.simulation.world.hand_rule import ARM_STIFFNESS_N_M, FORCE_CAP, HandRule
from handcart.backends.simulation.world.scene import Scene
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import inverse
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.numerics.arrays import FloatArray

from .arm_contact import LOAD_NAME, NO_TOUCH, ArmContact, Touch
from .sliding import push_out, slide

_MOST_SLIDING = 3.0  # times the commanded travel of a link
_STEP = 0.02  # that a link goes between two looks: panels and boards are as thick [m]
_GRAZES = 0.003  # [m]
_HALVINGS = 7
_PUSHES = 3  # by which a hand that slid is put back out of what it meets
_CLEAR = 1e-5  # [m]


class SimulatedHand:
    """Quasi-static motion of a simulated arm among solid things.

    The arm stops at the posture where a contact begins. The force on the hand (`scene.hand_force`) grows by 2
    N for each millimetre by which the commanded hand position is behind the contact, up to 60 N, at which the
    drives yield. If the hand presses on a surface and is commanded along it, it slides with friction; if
    another part of the arm touches something, the arm stops. A `HandRule` of a domain decides which bodies
    give way instead.
    """

    def __init__(self, scene: Scene, arm: ArmModel) -> None:
        self.scene, self.arm = scene, arm
        self.contact = ArmContact(scene, arm)
        found = {name: props.hand_rule(arm) for name, props in scene.props.items()}
        self.rules: dict[str, HandRule] = {name: rule for name, rule in found.items() if rule is not None}
        """Rules by the domain's name."""

    def forget_derived(self) -> None:
        """Discard cached values, because other code has changed the simulated scene."""
        self.contact = ArmContact(self.scene, self.arm)

    # Motion

    def move(self, target: FloatArray) -> frozenset[tuple[str, str]]:
        """Move the arm from `scene.joints` towards joint positions, as far as solids and the rules of domains
        (`HandRule`) allow it.

        The scene's joints, pose of the held object and force on the hand are updated.

        Args:
            target: (n,) commanded joints, in [rad] or [m].

        Returns:
            Pairs of bodies that touch: the name of a part of the robot, and the name of the other body.
        """
        scene, start = self.scene, self.scene.joints
        for rule in self.rules.values():
            rule.aim(target)
        posture, pairs = self._stop_at_solids(start, target)
        pushed, rigid = 0.0, posture is not target
        for rule in self.rules.values():
            met = rule.meet(start, posture)
            posture, pushed, pairs = met.joints, max(pushed, met.force), pairs | met.pairs
        scene.joints = posture
        before = {rule: rule.strain for rule in self.rules.values()}
        drag = self.carry(start) if scene.held is not None else np.zeros(3)
        wrenched = [rule for rule, strain in before.items() if rule.strain > max(1.0, strain)]
        if wrenched:
            scene.joints = posture = start
            drag = self.carry(start)
            pairs |= {(LOAD_NAME, rule.strained_by) for rule in wrenched}
        scene.hand_force = self._reaction(target, posture, 0.0 if rigid else pushed) + drag
        return pairs

    def met_at(self, base: Pose2) -> Touch:
        """Return the contact that arm, load and mounted parts would have with the base at another pose.

        The base's own body is excluded, because `move_base` checks its footprint.

        Args:
            base: pose world_T_base.

        Returns:
            The deepest contact at the other pose. `NO_TOUCH` if there is none, or if the contact at the
            base's present pose is at least as deep.
        """
        there = self.contact.deepest_of_robot(base, self.scene.joints, self._skip)
        if there.depth == 0.0:
            return NO_TOUCH
        here = self.contact.deepest_of_robot(self.scene.base, self.scene.joints, self._skip)
        return NO_TOUCH if there.depth <= here.depth else there

    def follow_base(self) -> None:
        """Move the held object with the hand, after the simulated base was moved."""
        if self.scene.held is not None:
            self.carry(self.scene.joints)

    def _stop_at_solids(
        self, start: FloatArray, target: FloatArray
    ) -> tuple[FloatArray, frozenset[tuple[str, str]]]:
        """Return the joints at which the arm stops or slides on its way, and the touching pairs.

        The way is a straight line in the joints. A motion that reduces an overlap is always free.

        Args:
            start: (n,) joints at the start, in [rad] or [m].
            target: (n,) commanded joints, in [rad] or [m].
        """
        free, blocked, there = self._first_hit(start, target)
        if there.depth == 0.0:
            return target, frozenset()
        here = self.contact.deepest_of_arm(start, self._skip)
        if here.depth > 0.0:
            there = self.contact.deepest_of_arm(target, self._skip)
            end = target if there.depth <= here.depth else start
            return end, frozenset({(here.body, here.other)})
        for _ in range(_HALVINGS):
            middle = (free + blocked) / 2
            hit = self.contact.deepest_of_arm(start + middle * (target - start), self._skip)
            free, blocked, there = (middle, blocked, there) if hit.depth == 0.0 else (free, middle, hit)
        stands = start + free * (target - start)
        return self._slide(stands, target, there), frozenset({(there.body, there.other)})

    def _slide(self, stands: FloatArray, target: FloatArray, met: Touch) -> FloatArray:
        """Return the joints (n,) at which a touching arm that is commanded further comes to rest; `stands` if
        it sticks.

        Args:
            stands: (n,) joints at the contact, in [rad] or [m].
            target: (n,) commanded joints, in [rad] or [m].
            met: the contact.
        """
        if not self.contact.rides_on_hand(met.body) or not any(met.normal):
            return stands
        base_T_world = inverse(self.scene.world_T_base)
        normal = base_T_world[:3, :3] @ met.normal
        point = (base_T_world @ (*met.point, 1.0))[:3]
        end = slide(self.arm, stands, target, point, normal)
        if end is None:
            return stands
        for _ in range(_PUSHES):
            hit = self.contact.deepest_of_arm(end, self._skip)
            if hit.depth == 0.0:
                break
            end = push_out(self.arm, end, (hit.depth + _CLEAR) * normal)
        if self.contact.travel(stands, end) > _MOST_SLIDING * self.contact.travel(stands, target) + _GRAZES:
            return stands  # near a singular posture no small motion of the joints slides it
        free, _, there = self._first_hit(stands, end)
        return end if there.depth == 0.0 else stands + free * (end - stands)

    def _first_hit(self, start: FloatArray, target: FloatArray) -> tuple[float, float, Touch]:
        """Return the first overlap on the straight line between two postures, in steps too short to miss a
        thin board.

        Contacts that the arm only grazes on its way do not stop it.

        Args:
            start: (n,) joints at the start, in [rad] or [m].
            target: (n,) joints at the end, in [rad] or [m].

        Returns:
            Share of the line, 0 to 1, at the last free posture, share at the first posture with an overlap,
            and the overlap.
        """
        steps = max(1, int(np.ceil(self.contact.travel(start, target) / _STEP)))
        for number in range(1, steps + 1):
            share = number / steps
            posture = target if number == steps else start + share * (target - start)
            there = self.contact.deepest_of_arm(posture, self._skip)
            if there.depth > (0.0 if number == steps else _GRAZES):
                return share - 1.0 / steps, share, there
        return 0.0, 1.0, NO_TOUCH

    def _skip(self, body: str, other: str) -> bool:
        """Return whether a rule, instead of rigid geometry, decides a pair of bodies."""
        return any(rule.decides(body, other) for rule in self.rules.values())

    def _reaction(self, target: FloatArray, posture: FloatArray, pushed: float) -> FloatArray:
        """Return the force (3,) on the hand, in the hand frame, in [N], that pushes it back from its command.

        Args:
            target: (n,) commanded joints, in [rad] or [m].
            posture: (n,) joints of the arm, in [rad] or [m].
            pushed: size of a force against the hand's x axis that replaces the computed one, in [N]; 0: none
                does.
        """
        if posture is target:
            return np.zeros(3)
        base_T_hand = self.arm.forward(posture)
        beyond = self.arm.forward(target)[:3, 3] - base_T_hand[:3, 3]
        force = -ARM_STIFFNESS_N_M * (base_T_hand[:3, :3].T @ beyond)
        if pushed > 0.0:
            force[0] = -pushed
        size = float(np.linalg.norm(force))
        return np.asarray(force * min(1.0, FORCE_CAP / size) if size > 0.0 else force)

    def carry(self, start: FloatArray) -> FloatArray:
        """Move the held object with the hand, as far as the rule of the object's application domain allows
        it.

        Args:
            start: (n,) joints at the start of the period, in [rad] or [m].

        Returns:
            Force (3,) on the hand by contacts of the object, in the hand frame, in [N].
        """
        scene, thing = self.scene, self.scene.held
        assert thing is not None
        world_T_hand = scene.world_T_base @ self.arm.forward(scene.joints)
        thing.pose = world_T_hand @ scene.hand_T_held
        force = np.zeros(3)
        for rule in self.rules.values():
            force = force + rule.carry(thing, world_T_hand, start)
        return force
