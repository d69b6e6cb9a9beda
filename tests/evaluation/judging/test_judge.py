"""The judge must be able to find a lie."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handcart.backends.capabilities.base import Base
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.simulation.books.book_props import BookProps
from handcart.evaluation.books.shelving import longest_rising, shelving
from handcart.evaluation.judging.judge import Judge
from handcart.evaluation.judging.true_changes import not_restored
from handcart.networks.events.events import Ended, Started
from handcart.networks.events.run_end import RunEnd
from handcart.networks.runs.run import prepare
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.outcomes.outcome import Outcome, Success, fail_if_restored
from handcart.primitives.outcomes.residual import read_residuals
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import transform
from handcart.robotics.perception.books.call_number import parse
from tests.tools.conftest import LIBRARY, TOUR

DRIVE_MAP = LIBRARY.parent / "drive_map" / "task.yaml"
FETCH = LIBRARY.parent / "fetch_and_carry" / "task.yaml"


def test_a_fail_that_did_not_restore_is_found(build_rig: Callable[..., Any]) -> None:
    backend, robot = build_rig().backend, load_robot("librarian")
    scene, before = backend.scene, backend.ground_truth()
    assert before is not None

    def wrong() -> list[str]:
        after = backend.ground_truth()
        assert before is not None
        assert after is not None
        return not_restored(before, after, robot)

    assert wrong() == []
    scene.base = Pose2(scene.base.x + 0.1, scene.base.y, scene.base.theta)
    assert any("base mm" in item for item in wrong())
    scene.base = before.base
    scene.joints = scene.joints + np.array([0.0, 0.02, 0.0, 0.0, 0.0, 0.0])
    assert any("joints deg" in item for item in wrong())
    scene.joints = before.joints
    book = next(iter(scene.of(BookProps).things()))
    book.pose = book.pose.copy()
    book.pose[2, 3] -= 0.5
    assert any("book" in item for item in wrong())


def test_a_book_on_the_tray_is_not_in_its_slot(build_rig: Callable[..., Any]) -> None:
    books = build_rig().backend.scene.of(BookProps)
    judged = shelving(books, (books.tray_book().accession,)).judge(books)
    assert not judged.slot_correct
    assert not judged.right


def test_a_task_that_only_drives_returns_no_book(tmp_path: Path) -> None:
    for name in ("world.yaml", "map.yaml", "map.png", "places.yaml", "catalogue.yaml"):
        (tmp_path / name).write_bytes((LIBRARY / name).read_bytes())
    (tmp_path / "tour.yaml").write_text(TOUR, encoding="utf-8")
    with prepare(tmp_path / "tour.yaml") as prepared:
        judge = Judge(prepared)
        end = RunEnd("Success", "at_shelf", "", 1, 0, 0, ())
        assert judge.figures(end)["untrue"] == []


class Claims:
    """A judge who hears that MOVE_TO has succeeded, whatever the robot did."""

    def __init__(self, prepared: Any) -> None:
        self.prepared, self.robot, self.scene = prepared, prepared.robot, prepared.backend.scene
        self.wheels = prepared.backend.get(Base)
        self.judge = Judge(prepared)
        self.action = next(action for action in prepared.task.network.actions if action.do == "MOVE_TO")
        self.place = next(name for name, place in prepared.model.places.items() if place.shelf is None)

    def start(self) -> None:
        self.primitive = MoveTo(place=self.place)
        self.judge.event(Started(self.robot.time, 1, self.action, self.primitive, 0))

    def drive(self, speed: float, periods: int) -> None:
        for _ in range(periods):
            self.wheels.drive(speed, 0.0)  # past the guard that holds every primitive
            self.robot.step()
            self.judge.period(self.robot)

    def end(self, outcome: Outcome = Success()) -> list[str]:
        self.judge.event(Ended(self.robot.time, 1, self.action, self.primitive, outcome, {}))
        return self.judge.untrue

    def metrics(self) -> Mapping[str, Any]:
        return self.judge.figures(RunEnd("Success", "", "", 1, 0, 0, ()))


@pytest.fixture
def claims() -> Iterator[Claims]:
    with prepare(DRIVE_MAP) as prepared:
        yield Claims(prepared)


def test_a_success_that_rammed_a_mapped_wall_is_untrue(claims: Claims) -> None:
    """Contacts are listed in the metrics and contradict MOVE_TO's Success."""
    scene, reach = claims.scene, claims.scene.robot.footprint_radius_m
    x, y = scene.base.x, scene.base.y
    gap = scene.body_plan.clearance(x, y, 0.0)[0]
    claims.start()
    headings = np.linspace(0.0, 2 * np.pi, 64, endpoint=False)
    ahead = [scene.body_plan.clearance(x + gap * np.cos(h), y + gap * np.sin(h), 0.0)[0] for h in headings]
    scene.move_base(Pose2(x, y, float(headings[int(np.argmin(ahead))])))
    claims.drive(0.5, round((gap - reach + 0.2) / 0.5 / claims.robot.period))
    assert any("1. MOVE_TO Success: base touched wall on the map" in item for item in claims.end())
    assert claims.metrics()["contacts_of_base"] > 0
    assert claims.metrics()["untrue"]


def test_a_fail_is_held_against_how_it_began(claims: Claims) -> None:
    """Whatever the robot has measured."""
    measured = fail_if_restored(
        "the way is blocked", False, read_residuals({"base_mm": 1.0}, {"base_mm": 25.0})
    )
    claims.start()
    assert claims.end(measured) == []
    claims.start()
    claims.scene.move_base(claims.scene.base.compose(Pose2(0.0, 0.1, 0.0)))
    (wrong,) = claims.end(measured)
    assert wrong.startswith("1. MOVE_TO Fail: base mm 100.00 (at most ")


@pytest.mark.parametrize(
    ("rpy_deg", "turn_deg"),
    [
        ((0.0, 0.0, 0.0), None),
        ((0.0, 0.0, 4.0), None),
        ((0.0, 0.0, 20.0), "20.00"),
        ((90.0, 0.0, 0.0), "90.00"),
        ((0.0, 180.0, 0.0), "180.00"),
    ],
)
def test_a_body_turned_or_tipped_where_it_is_is_found(
    rpy_deg: tuple[float, float, float], turn_deg: str | None
) -> None:
    """Neither a Fail nor the Success of a drive may leave it so, although its middle has not moved."""
    with prepare(FETCH) as prepared:
        claims = Claims(prepared)
        thing = claims.scene.thing_named("object parcel_1")
        failed = fail_if_restored("blocked", False, read_residuals({}, {}))
        for outcome, begins in ((failed, ""), (Success(), "it turned ")):
            claims.start()
            claims.judge.untrue.clear()
            thing.pose = thing.pose @ transform(rpy=np.radians(rpy_deg).tolist())
            word = type(outcome).__name__
            found = [item for item in claims.end(outcome) if "object parcel_1" in item]
            assert found == [
                f"1. MOVE_TO {word}: {begins}object parcel_1 deg {text} (at most 5.00)"
                for text in [turn_deg]
                if text
            ]


def test_arrival_is_held_against_the_truth(claims: Claims) -> None:
    place = claims.prepared.model.places[claims.place].pose
    claims.start()
    claims.scene.move_base(place)
    claims.robot.localization.found_at(place, (0.001, 0.001))
    assert claims.end() == []
    claims.scene.move_base(place.compose(Pose2(0.0, 0.06, 0.03)))
    claims.judge.period(claims.robot)
    claims.start()
    assert claims.end() == [
        "1. MOVE_TO Success: the base is 60.0 mm from its place (at most 40.0)",
        "1. MOVE_TO Success: the base is 1.72 deg off (at most 1.0)",
    ]
    metrics = claims.metrics()
    assert metrics["arrival_mm_max"] == pytest.approx(60.0, abs=0.01)
    assert metrics["localisation_mm_max"] >= 59.0
    assert metrics["localisation_deg_max"] >= 1.7


def test_the_longest_rising_row_leaves_the_misplaced_book_out() -> None:
    calls = ["100 AAA", "200 AAA", "150.5 BBB", "150.15 BBB", "300 AAA", "120 CCC", "400 AAA"]
    numbers = [number for call in calls if (number := parse(call))]
    rising = longest_rising(numbers)
    assert [calls[i] for i in rising] == ["100 AAA", "150.15 BBB", "300 AAA", "400 AAA"]
