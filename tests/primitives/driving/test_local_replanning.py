"""MOVE_TO among obstacles that no map shows, at its public face on the kinematic backend."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from handcart.primitives.driving.local_replanning import LocalReplanning
from handcart.primitives.driving.modify import Modify
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.knowledge.place import Place
from handcart.primitives.knowledge.world_model import WorldModel
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.outcome import Fail, Success
from tests.primitives.conftest import Rig

BOX = "  - {{name: box {n}, x_m: {x}, y_m: {y}, heading_deg: 20, size_m: [0.5, 0.4, 0.6]{more}}}\n"
WALL = "  - {name: barrier, x_m: 4.0, y_m: 4.3, size_m: [7.9, 0.1, 1.0]}\n"


def boxes(*places: tuple[float, float], more: str = "") -> str:
    """Lines of a world's file."""
    lines = [BOX.format(n=n, x=x, y=y, more=more) for n, (x, y) in enumerate(places)]
    return "surprises:\n" + "".join(lines)


@pytest.mark.slow
def test_unmapped_boxes_are_driven_around_without_a_fail(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig(boxes((3.0, 1.1), (4.6, 2.0)))
    assert isinstance(rig.run(MoveTo(place="shelf_1")), Success)
    assert rig.restored == []
    assert rig.scene.contacts == []
    assert math.dist(rig.scene.base[:2], (6.5, 4.93)) < 0.04
    assert len(rig.model.sensed_cells) > 10  # readings are kept for later drives


@pytest.mark.slow
def test_closed_wall_is_a_restored_fail_that_modify_knows(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig("surprises:\n" + WALL)
    before = rig.scene.base
    failed = rig.run(MoveTo(place="shelf_1", wait_s=1.0))
    assert isinstance(failed, Fail)
    assert "an obstacle is on the path to shelf_1" in failed.reason
    assert "no other way leads there" in failed.reason
    assert math.dist(before[:2], rig.scene.base[:2]) < 0.03
    assert rig.scene.contacts == []
    assert rig.robot.time < 60.0
    planned = rig.run(Modify(place="shelf_1"))
    assert isinstance(planned, Fail)
    assert "past what was sensed" in planned.reason


def test_sensed_cells_are_kept_in_a_state_and_old_states_load(make_rig: Callable[..., Rig]) -> None:
    model = make_rig().model
    model.sensed_cells = np.array([[1.0, 2.0, 7.0, 3.5]])
    state = model.state()
    other = WorldModel(model.map, model.places)
    other.set_state(state)
    assert np.array_equal(other.sensed_cells, model.sensed_cells)
    del state["sensed_cells"]
    third = WorldModel(model.map, model.places)
    third.set_state(state)
    assert third.sensed_cells.shape == (0, 4)


@pytest.mark.slow
def test_restoring_takes_another_way_where_something_moved_behind(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig(boxes((2.0, 1.2), more=", appears_s: 7"))
    before = rig.scene.base
    outcome = rig.run(MoveTo(place="shelf_1", wait_s=1.0), cancel=lambda: rig.robot.time > 7.0)
    assert isinstance(outcome, Fail), outcome
    assert math.dist(before[:2], rig.scene.base[:2]) < 0.03
    assert rig.scene.contacts == []


@pytest.mark.slow
def test_route_changes_while_driving_before_anything_holds_the_base(make_rig: Callable[..., Rig]) -> None:
    """A box appears 2 m ahead: a look at the layer leads around it, so the guard has nothing to stop."""
    rig = make_rig(boxes((4.3, 1.9), more=", appears_s: 3"))
    held: list[float] = []

    def watch() -> bool:
        if rig.robot.held is not None and rig.robot.time > 3.0:
            held.append(rig.robot.time)
        return False

    assert isinstance(rig.run(MoveTo(place="shelf_1"), cancel=watch), Success)
    assert rig.scene.contacts == []
    assert [time for time in held if time < 12.0] == []


@pytest.mark.slow
def test_slip_and_a_wrong_tread_make_no_oscillation(make_rig: Callable[..., Rig]) -> None:
    """15 % of slip, 5 % of tread: the drive turns hardly more often than with good wheels.

    Until it is there: such wheels take up to four corrections to stand within 4 mm before a shelf.
    """
    found = {}
    for name, errors in (("good", {}), ("bad", {"slip_percent": 15.0, "tread_percent": 5.0})):
        rig = make_rig(boxes((4.3, 1.9)), seed=0, errors=errors)
        turns: list[float] = []
        driven: list[float] = []

        def watch(rig: Rig = rig, turns: list[float] = turns, driven: list[float] = driven) -> bool:
            rate = rig.robot.driven[1]
            if rig.robot.pose.distance(rig.model.places["shelf_1"].pose) > 0.1:
                driven.append(rig.robot.time)
                if abs(rate) > 0.15 and (not turns or rate * turns[-1] < 0.0):
                    turns.append(rate)
            return False

        outcome = rig.run(MoveTo(place="shelf_1"), cancel=watch)
        assert isinstance(outcome, Success) or (isinstance(outcome, Fail) and outcome.cause is not None)
        assert rig.scene.contacts == []
        found[name] = (len(turns), driven[-1])
    assert found["bad"][0] <= found["good"][0] + 6
    assert found["bad"][1] < 1.3 * found["good"][1] + 2.0


@pytest.mark.slow
def test_goal_at_which_the_base_cannot_turn_is_a_fail_in_time(make_rig: Callable[..., Rig]) -> None:
    """The crate is nearer to the goal than a corner of the base: backing off and returning do not help."""
    crate = "surprises:\n  - {name: crate, x_m: 5.75, y_m: 1.2, size_m: [0.3, 0.3, 0.6]}\n"
    rig = make_rig(crate, robot="husky", start_y=1.2)
    rig.model.places = {**rig.model.places, "turned": Place(x_m=5.0, y_m=1.2, heading_deg=90.0)}
    before, step = rig.scene.base, rig.robot.step

    def watched_step(paused: bool = False) -> None:
        step(paused)
        assert rig.robot.time < 100.0, "it goes on without end"

    rig.robot.step = watched_step  # type: ignore[method-assign]
    failed = rig.run(MoveTo(place="turned"))
    assert isinstance(failed, Fail), failed
    assert failed.cause in (causes.BLOCKED, causes.NO_PROGRESS)
    assert math.dist(before[:2], rig.scene.base[:2]) < 0.03
    assert rig.scene.contacts == []


def test_wait_that_ends_with_nothing_ahead_is_still_explained(make_rig: Callable[..., Rig]) -> None:
    """At the goal itself the route ahead is empty; the message names the goal then."""
    rig = make_rig()
    view = rig.model.view(MoveTo(place="shelf_1"))  # type: ignore[arg-type]
    local = LocalReplanning(rig.robot, view, "shelf_1")
    goal = rig.model.places["shelf_1"].pose
    found = local.give_up_waiting(np.empty((0, 2)))
    assert f"({goal.x:.2f}, {goal.y:.2f}) m" in found.reason
