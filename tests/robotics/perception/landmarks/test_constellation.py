"""Identification of landmarks that look alike."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import BoolArray, FloatArray
from handcart.robotics.perception.landmarks.constellation import (
    BasePrior,
    Kind,
    MarkAssignment,
    PlannedMark,
    explain,
    rivals,
)

KIND, HIGHER = Kind(0.4, 0.06), Kind(0.6, 0.06)
HALF = (0.09, 0.06)  # [m] from the middle of a picture to where a landmark's middle may be
ABOUT = np.diag([0.05, 0.05, 0.035]) ** 2
SURE = np.diag([0.01, 0.01, 0.01]) ** 2
HERE = Pose2(0.0, 0.0, 0.0)


def row(count: int, spacing: float = 0.09, kind: Kind = KIND) -> list[PlannedMark]:
    """Landmarks side by side along y, the middle one ahead of the base."""
    return [PlannedMark(kind, Pose2(0.1, 0.5 + spacing * (n - (count - 1) / 2), 0.0)) for n in range(count)]


def within(views: Sequence[Sequence[float]], places: Sequence[Sequence[float]]) -> BoolArray:
    """Whether places are in one of the pictures, by the pictures' middles."""
    return np.array([any(np.all(np.abs(np.subtract(at[:2], v)) < HALF) for v in views) for at in places])


def look(
    marks: list[PlannedMark],
    lying: list[PlannedMark],
    base: Pose2,
    views: Sequence[Sequence[float]],
    covariance: FloatArray = ABOUT,
    believed: Pose2 = HERE,
    noise: np.random.Generator | None = None,
) -> list[MarkAssignment]:
    """Return the result of pictures about `views`, base frame, from a base that is truly at `base`."""
    at = [(kind, base.inverse().compose(place)) for kind, place in lying]
    seen = [{kind: place} for kind, place in at if within(views, [place])[0]]
    if noise is not None:
        seen = [
            {k: p.compose(Pose2(*noise.normal(0, (5e-4, 5e-4, 5e-4)))) for k, p in s.items()} for s in seen
        ]
    return explain(marks, seen, BasePrior(believed, covariance), lambda _, places: within(views, places))


def along(count: int, spacing: float = 0.09, x: float = 0.1) -> list[tuple[float, float]]:
    """Pictures along the row."""
    return [(x, 0.5 + spacing * (n - (count - 1) / 2)) for n in range(count)]


@pytest.mark.parametrize("shift", [-0.09, -0.05, 0.0, 0.05, 0.09])
def test_row_with_visible_ends_is_not_shifted_by_one(shift: float) -> None:
    marks, base = row(5), Pose2(0.01, shift, 0.03)
    best, *others = rivals(look(marks, marks, base, along(9)))
    assert not others
    assert best.planned_T_base == pytest.approx(base, abs=1e-9)
    assert best.marks == (0, 1, 2, 3, 4)


def test_middle_of_a_long_row_is_reported_as_ambiguous() -> None:
    marks = row(11)
    found = rivals(look(marks, marks, HERE, along(3)))
    shifts = sorted(round(item.planned_T_base.y, 3) for item in found)
    assert found[0].planned_T_base == pytest.approx(HERE, abs=1e-9)
    assert {-0.09, 0.0, 0.09} <= set(shifts)


def test_where_the_base_is_well_known_one_landmark_is_enough() -> None:
    marks = row(5)
    (best,) = rivals(look(marks, marks, HERE, [(0.1, 0.5)], SURE))
    assert best.marks == (2,)


def test_a_base_that_was_moved_is_found_by_what_is_seen_or_it_is_said() -> None:
    """One landmark further, one mark too many and one too few stand against what is believed."""
    marks = row(5)
    one, three = Pose2(0.0, 0.09, 0.0), Pose2(0.0, 0.27, 0.0)
    assert len(rivals(look(marks, marks, one, along(9), SURE))) == 2
    (best,) = rivals(look(marks, marks, three, along(15), SURE))
    assert best.planned_T_base == pytest.approx(three, abs=1e-9)


@pytest.mark.parametrize("missing", range(5))
def test_with_a_landmark_missing_none_is_taken_for_another(missing: int) -> None:
    """Where an end of the row is missing, it may as well be the other one: that is said."""
    marks, base = row(5), Pose2(0.0, 0.02, 0.01)
    lying = [mark for i, mark in enumerate(marks) if i != missing]
    best, *others = rivals(look(marks, lying, base, along(9)))
    assert any(other.planned_T_base == pytest.approx(base, abs=1e-9) for other in (best, *others))
    assert bool(others) == (missing in (0, 4))


@pytest.mark.parametrize("place", [(0.02, 0.45), (0.15, 0.61), (0.1, 0.815)])
def test_one_mark_too_many_is_none_of_the_plan(place: tuple[float, float]) -> None:
    marks, base = [*row(5), PlannedMark(KIND, Pose2(0.01, 0.55, 0.0))], Pose2(0.01, -0.03, 0.02)
    lying = [*marks, PlannedMark(KIND, Pose2(*place, 0.0))]
    best, *others = rivals(look(marks, lying, base, [*along(9), *along(9, x=0.0)]))
    assert not others
    assert best.marks.count(None) == 1
    assert best.planned_T_base == pytest.approx(base, abs=1e-9)


def test_one_mark_too_many_where_the_row_goes_on_is_said() -> None:
    marks = row(4)
    lying = [*marks, PlannedMark(KIND, Pose2(0.1, marks[-1].place.y + 0.09, 0.0))]
    assert len(rivals(look(marks, lying, HERE, along(9)))) > 1
    assert len(rivals(look(marks, lying, HERE, along(9), SURE))) == 1


def test_landmarks_of_another_height_and_heading_tell() -> None:
    plain = row(3)
    low_and_high = [plain[0], plain[1]._replace(kind=HIGHER), plain[2]]
    turned = [mark._replace(place=mark.place._replace(theta=0.5 * i)) for i, mark in enumerate(plain)]
    view = [(0.1, 0.5)]
    assert len(rivals(look(plain, plain, HERE, view))) > 1
    for marks in (low_and_high, turned):
        (best,) = rivals(look(marks, marks, HERE, view))
        assert best.marks == (1,)


def test_nothing_seen_explains_nothing() -> None:
    marks = row(3)
    assert look(marks, marks, HERE, [(1.0, 1.0)]) == []


@pytest.mark.slow
def test_what_is_believed_is_true_on_plans_of_any_kind() -> None:
    """Rows and grids, exact or not; one covered, one too many, looked at in parts. A mark too many that is
    seen alone is taken for a landmark: nothing speaks against it."""
    rng, sure = np.random.default_rng(1), 0
    for _ in range(100):
        step = rng.uniform(0.07, 0.12, 2)
        grid = [(0.1 + i * step[0], 0.5 + j * step[1]) for i in range(rng.integers(1, 3)) for j in range(5)]
        jitter = rng.choice([0.0, 0.015]) * rng.standard_normal((len(grid), 2))
        marks = [PlannedMark(KIND, Pose2(x, y, 0.0)) for x, y in (np.array(grid) + jitter).tolist()]
        lying = list(marks)
        if rng.random() < 0.3:
            del lying[rng.integers(len(lying))]
        if rng.random() < 0.3:
            x, y = rng.uniform((0.0, 0.4), (0.3, 1.0))
            lying.append(PlannedMark(KIND, Pose2(x, y, 0.0)))
        base = Pose2(*rng.normal(0.0, (0.05, 0.05, 0.035)))
        views = rng.uniform((0.05, 0.4), (0.25, 1.0), (rng.integers(1, 6), 2)).tolist()
        found = look(marks, lying, base, views, noise=rng)
        if found and len(found[0].marks) > 1 and len(rivals(found)) == 1:
            sure += 1
            assert found[0].planned_T_base.distance(base) < 0.005
    assert sure > 20
