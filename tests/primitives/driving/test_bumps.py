"""A base that runs into what no sensor shows: it stops, remembers, and goes another way."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from handcart.primitives.driving.modify import Modify
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.knowledge.world_model import WorldModel
from handcart.primitives.outcomes.outcome import Fail, Success
from tests.primitives.conftest import Rig

LOW = "  - {{name: box, x_m: {x}, y_m: {y}, size_m: [{wide}, {deep}, 0.2]}}\n"  # below the lidar


def pushing(rig: Rig) -> list[float]:
    """Time in [s] of the periods in which the base touches the box; filled while the rig runs."""
    times: list[float] = []
    step = rig.robot.step

    def and_look(paused: bool = False) -> None:
        step(paused)
        if ("base", "box") in rig.scene.touching:
            times.append(rig.robot.time)

    rig.robot.step = and_look  # type: ignore[method-assign]
    return times


@pytest.mark.slow
def test_a_low_box_is_run_into_once_and_then_driven_around(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig(furniture=LOW.format(x=3.6, y=1.3, wide=0.4, deep=0.4))
    times = pushing(rig)
    failed = rig.run(MoveTo(place="shelf_1"))
    assert isinstance(failed, Fail)
    assert not failed.permanent
    assert "ran into something that no sensor shows, at about (3.3" in failed.reason
    ((x, y, direction),) = rig.model.bumps.tolist()
    assert abs(x + 0.34 * np.cos(direction) - 3.4) < 0.06  # the near side of the box
    assert abs(y + 0.34 * np.sin(direction) - 1.3) < 0.2
    assert isinstance(rig.run(Modify(place="shelf_1")), Success)
    assert isinstance(rig.run(MoveTo(place="shelf_1")), Success)
    assert len(rig.scene.contacts) == 1
    assert times[-1] - times[0] <= 1.0


@pytest.mark.slow
def test_it_goes_around_without_being_told_to_modify(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig(furniture=LOW.format(x=3.6, y=1.3, wide=0.4, deep=0.4))
    assert isinstance(rig.run(MoveTo(place="shelf_1")), Fail)
    assert isinstance(rig.run(MoveTo(place="shelf_1")), Success)
    assert len(rig.scene.contacts) == 1


@pytest.mark.slow
def test_modify_fails_where_no_other_way_exists(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig(furniture=LOW.format(x=4.0, y=4.4, wide=7.9, deep=0.2))  # from wall to wall
    assert isinstance(rig.run(MoveTo(place="shelf_1")), Fail)
    rig.model.bumps = np.vstack([rig.model.bumps, [[x, 4.0, np.pi / 2] for x in np.arange(0.4, 7.9, 0.8)]])
    failed = rig.run(Modify(place="shelf_1"))
    assert isinstance(failed, Fail)
    assert failed.permanent
    assert "no way around leads to shelf_1: the base ran into something at about" in failed.reason
    again = rig.run(MoveTo(place="shelf_1"))
    assert isinstance(again, Fail)
    assert again.permanent
    assert len(rig.scene.contacts) == 1


def test_bumps_are_noted_kept_in_a_state_and_old_states_go_on(make_rig: Callable[..., Rig]) -> None:
    model = make_rig().model
    model.taken_changes()
    model.bumps = np.array([[1.0, 2.0, 0.5]])
    assert model.taken_changes() == {"bumps": [[1.0, 2.0, 0.5]]}
    other = WorldModel(model.map, model.places)
    state = model.state()
    other.set_state(state)
    assert np.array_equal(other.bumps, model.bumps)
    del state["bumps"]
    older = WorldModel(model.map, model.places)
    older.set_state(state)
    assert older.bumps.shape == (0, 3)
