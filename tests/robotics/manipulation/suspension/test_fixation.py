import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, inverse, transform
from handcart.robotics.manipulation.suspension.fixation import (
    PAPER_RULE,
    PlannedView,
    StopRule,
    on_floor,
    placing_posture,
    split_goal,
)

DOWN = np.diag([1.0, -1.0, -1.0, 1.0])


class Stage:
    """A base beside its planned place, with frames drawn at random: the paper's Fig. 1."""

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)

        def pose(reach: float) -> Transform:
            return transform(rng.uniform(-reach, reach, 3).tolist(), rng.uniform(-1.5, 1.5, 3).tolist())

        self.world_T_planned, self.view = pose(5.0), PlannedView(pose(0.6), pose(0.1), pose(0.4))
        self.planned_T_base = pose(0.2)
        self.world_T_base = self.world_T_planned @ self.planned_T_base  # eq. 3
        view = self.view
        self.world_T_landmark = (
            self.world_T_planned @ view.base_T_hand @ view.hand_T_camera @ view.camera_T_landmark
        )  # eq. 1
        self.world_T_goal = pose(5.0)
        self.base_T_hand = pose(0.6)  # any posture on the way

    def seen(self, base_T_hand: Transform) -> Transform:
        """camera_T_landmark (eq. 2, corrected)."""
        return inverse(self.world_T_base @ base_T_hand @ self.view.hand_T_camera) @ self.world_T_landmark


def apart(a: Transform, b: Transform) -> float:
    return float(np.abs(a - b).max())


@pytest.fixture(params=range(20))
def stage(request: pytest.FixtureRequest) -> Stage:
    return Stage(request.param)


def test_equation_2_needs_the_actual_view(stage: Stage) -> None:
    M0T60, X, C0TP0 = stage.view
    chain = stage.world_T_base @ M0T60 @ X
    assert apart(stage.world_T_landmark, chain @ stage.seen(M0T60)) < 1e-12
    assert apart(stage.world_T_landmark, chain @ C0TP0) > 1e-3  # as printed


def test_equation_4_is_a_left_product(stage: Stage) -> None:
    seen = stage.seen(stage.view.base_T_hand)
    dT_C = stage.view.camera_error(seen)
    assert apart(stage.view.camera_T_landmark, dT_C @ seen) < 1e-12
    assert apart(stage.view.camera_T_landmark, seen @ dT_C) > 1e-3


def test_equation_5_at_the_planned_posture(stage: Stage) -> None:
    M0T60, X, _ = stage.view
    seen = stage.seen(M0T60)
    by_eq_5 = M0T60 @ X @ stage.view.camera_error(seen) @ inverse(X) @ inverse(M0T60)
    assert apart(by_eq_5, stage.planned_T_base) < 1e-12
    assert apart(stage.view.travelling_error(M0T60, seen), stage.planned_T_base) < 1e-12


def test_equations_6_to_8_put_the_block_where_it_belongs(stage: Stage) -> None:
    M0T60 = stage.view.base_T_hand
    base_T_hand = placing_posture(stage.planned_T_base, M0T60)
    assert apart(stage.seen(base_T_hand), stage.view.camera_T_landmark) < 1e-12  # eq. 6
    planned_T_goal = split_goal(stage.world_T_goal, stage.world_T_planned)
    base_T_goal = placing_posture(stage.planned_T_base, planned_T_goal)
    assert apart(stage.world_T_base @ base_T_goal, stage.world_T_goal) < 1e-12  # eq. 8


def test_equation_9_at_any_posture(stage: Stage) -> None:
    M0T60, X, C0TP0 = stage.view
    seen = stage.seen(stage.base_T_hand)
    dT_C = stage.view.camera_error(seen)
    left = stage.world_T_planned @ M0T60 @ X @ dT_C
    assert apart(left, stage.world_T_base @ stage.base_T_hand @ X) < 1e-12
    printed = stage.world_T_planned @ M0T60 @ C0TP0 @ dT_C
    assert apart(printed, stage.world_T_base @ stage.base_T_hand @ seen) > 1e-3


def test_one_move_does_it_and_equations_10_and_11_follow(stage: Stage) -> None:
    final = stage.view.next_hand(stage.base_T_hand, stage.seen(stage.base_T_hand))
    assert apart(stage.seen(final), stage.view.camera_T_landmark) < 1e-12
    hand = stage.world_T_planned @ stage.view.base_T_hand
    assert apart(hand, stage.world_T_base @ final) < 1e-12  # eq. 10
    assert apart(stage.world_T_planned @ final, stage.world_T_base @ final) > 1e-3  # as printed
    assert apart(stage.view.travelling_error_by_posture(final), stage.planned_T_base) < 1e-12  # eq. 11


def test_the_stop_residual_is_taken_in(stage: Stage) -> None:
    seen = stage.seen(stage.base_T_hand)
    assert apart(stage.view.travelling_error(stage.base_T_hand, seen), stage.planned_T_base) < 1e-12
    assert apart(stage.view.travelling_error_by_posture(stage.base_T_hand), stage.planned_T_base) > 1e-3


def fixate(base: Pose2, rule: StopRule, seed: int) -> tuple[PlannedView, Transform, Transform]:
    """The planned view, and hand and landmark as fixation leaves them, for a base that stands at `base`.

    The arm misses by 0.06 mm, the landmark is seen to 0.02 mm and 0.3 mrad. The first move but centres the
    landmark, as a search does, so that the base's turn is left to the rule.
    """
    rng = np.random.default_rng(seed)
    planned = PlannedView(transform((0.2, 0.45, 0.3)) @ DOWN, transform((0.0, 0.05, 0.0)), DOWN.copy())
    planned.camera_T_landmark[2, 3] = 0.3
    planned_T_landmark = planned.base_T_hand @ planned.hand_T_camera @ planned.camera_T_landmark
    base_T_landmark = inverse(base.lift()) @ planned_T_landmark
    centred = planned.base_T_hand.copy()
    centred[:3, 3] += (base_T_landmark - planned_T_landmark)[:3, 3]
    wanted = centred
    for _ in range(10):
        hand = wanted @ transform([*rng.normal(0.0, 6e-5, 2), 0.0])
        x, y, turn = (rng.normal(0.0, 1.0, 3) * (2e-5, 2e-5, 3e-4)).tolist()
        camera_T_landmark = (
            inverse(hand @ planned.hand_T_camera) @ base_T_landmark @ transform((x, y, 0.0), (0.0, 0.0, turn))
        )
        if rule.met(planned.camera_T_landmark, camera_T_landmark):
            return planned, hand, camera_T_landmark
        wanted = planned.next_hand(hand, camera_T_landmark)
    raise AssertionError("fixation doesn't end")


def block_error(base: Pose2, planned_T_base: Transform) -> float:
    """Return the distance of the block from its goal, 0.2 m from the landmark, in [m]."""
    planned_T_goal = transform((0.2, 0.60, 0.05))
    placed = base.lift() @ placing_posture(planned_T_base, planned_T_goal)
    return float(np.linalg.norm((placed - planned_T_goal)[:2, 3]))


@pytest.mark.parametrize("turn", [0.02, 0.05, 0.10, 0.15, -0.02, -0.15])
@pytest.mark.parametrize("seed", range(5))
def test_a_turn_that_the_papers_rule_lets_pass(turn: float, seed: int) -> None:
    base = Pose2(0.012, -0.03, turn)
    planned, hand, seen = fixate(base, PAPER_RULE, seed)
    assert block_error(base, planned.travelling_error(hand, seen)) < 0.0005
    by_paper = block_error(base, planned.travelling_error_by_posture(hand))
    assert 0.0035 < by_paper < 0.032
    assert by_paper == pytest.approx(0.2 * abs(turn), rel=0.1)


@pytest.mark.parametrize("turn", [0.02, 0.15])
def test_our_rule_leaves_little_even_without_the_residual(turn: float) -> None:
    base = Pose2(0.012, -0.03, turn)
    planned, hand, seen = fixate(base, StopRule(), 1)
    assert block_error(base, planned.travelling_error(hand, seen)) < 0.0005
    assert block_error(base, planned.travelling_error_by_posture(hand)) < 0.0015


def test_stop_rule_at_its_limits() -> None:
    planned, rule = transform((0.0, 0.0, 0.3)), StopRule(0.0005, 0.01)
    assert rule.met(planned, transform((0.00049, -0.00049, 0.31), (0.0, 0.0, -0.0099)))
    assert not rule.met(planned, transform((0.00051, 0.0, 0.3)))
    assert not rule.met(planned, transform((0.0, -0.00051, 0.3)))
    for turn in (0.0101, -0.0101):
        assert not rule.met(planned, transform((0.0, 0.0, 0.3), (0.0, 0.0, turn)))


def test_on_floor_drops_tilt_and_height() -> None:
    pose = (
        transform((0.1, -0.2, 0.003)) @ transform(rpy=(0.0, 0.0, 0.4)) @ transform(rpy=(0.004, -0.003, 0.0))
    )
    assert on_floor(pose) == pytest.approx((0.1, -0.2, 0.4), abs=1e-5)


@pytest.mark.parametrize(("off_mm", "met"), [(0.45, True), (-0.45, True), (0.55, False), (-0.55, False)])
@pytest.mark.parametrize("axis", [0, 1])
def test_half_a_millimetre_is_where_the_rule_ends(axis: int, off_mm: float, met: bool) -> None:
    planned = transform((0.1, 0.2, 0.3))
    seen = planned.copy()
    seen[axis, 3] += 1e-3 * off_mm
    assert StopRule().met(planned, seen) == met
    assert PAPER_RULE.met(planned, seen) == met
