"""Requests during a run: stop, cancel, pause and restore (rows N1 to N6, N11)."""

from typing import Any

import pytest

from handcart.backends.capabilities.base import WheelTravel
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.coordination.supervision import Request
from handcart.networks.events.events import Ended, Event
from handcart.networks.graph.network import ActionNetwork
from handcart.primitives.outcomes.outcome import Fail
from tests.networks.conftest import Stand


def coordinator(stand: Stand, network: ActionNetwork, **more: Any) -> Coordinator:
    return Coordinator(network, stand.robot, stand.model, **more)


def test_stop_holds_where_it_is(stand: Stand) -> None:
    run = coordinator(stand, stand.driving())
    end = stand.finish(run, {20: lambda: run.request(Request.STOP)})
    assert (end.outcome, end.exit_status) == ("Cancelled", 130)
    assert stand.robot.pose.x == pytest.approx(0.15)  # 15 of its 40 periods: it settles for 5 before
    assert stand.backend.stops == 2


def test_cancel_restores_first(stand: Stand) -> None:
    run = coordinator(stand, stand.driving())
    end = stand.finish(run, {30: lambda: run.request(Request.CANCEL)})
    assert (end.outcome, end.fails) == ("Cancelled", 1)
    assert abs(stand.robot.pose.x) < 0.02


def test_pause_holds_and_time_stands_still(stand: Stand) -> None:
    run = coordinator(stand, stand.driving())
    seen = []
    at = {
        20: lambda: run.request(Request.PAUSE),
        40: lambda: seen.append((stand.robot.time, stand.robot.pose, run.life.paused)),
        70: lambda: seen.append((stand.robot.time, stand.robot.pose, run.life.paused)),
        71: lambda: run.request(Request.RESUME),
    }
    end = stand.finish(run, at)
    assert seen[0] == seen[1]
    assert seen[0][2]
    assert end.outcome == "Success"
    assert stand.robot.pose.x == pytest.approx(0.4, abs=0.02)


def test_moved_during_a_pause_is_a_discrepancy(stand: Stand) -> None:

    def push() -> None:
        travel = stand.backend.wheels.travel
        stand.backend.wheels.travel = type(travel)(travel.left + 0.5, travel.right + 0.5)

    events: list[Event] = []
    run = coordinator(stand, stand.driving(), observers=[events.append])
    at = {20: lambda: run.request(Request.PAUSE), 40: push, 60: lambda: run.request(Request.RESUME)}
    end = stand.finish(run, at)
    outcomes = [event.outcome for event in events if isinstance(event, Ended)]
    assert isinstance(outcomes[0], Fail)
    assert "moved during a pause: base_mm" in outcomes[0].reason
    assert end.fails == 1


def test_cancel_while_paused(stand: Stand) -> None:
    run = coordinator(stand, stand.driving())
    at = {30: lambda: run.request(Request.PAUSE), 50: lambda: run.request(Request.CANCEL)}
    assert stand.finish(run, at).outcome == "Cancelled"
    assert abs(stand.robot.pose.x) < 0.02


def test_a_stop_does_not_wait_until_a_paused_robot_rests(stand: Stand) -> None:
    """A robot that trembles never rests; requests are heard all the same."""
    run = coordinator(stand, stand.driving())
    wheels: Any = stand.backend.wheels
    tremble: list[float] = []

    def travel() -> WheelTravel:
        tremble.append(0.01)
        return WheelTravel(sum(tremble), 0.0)

    def pause() -> None:
        wheels.wheel_travel = travel
        run.request(Request.PAUSE)

    stops = []
    at = {20: pause, 40: lambda: run.request(Request.STOP), 43: lambda: stops.append(stand.backend.stops)}
    end = stand.finish(run, at)
    assert end.outcome == "Cancelled"
    assert stops == [3]  # the pause's, then before and after the attempt is closed


def test_called_back_before_it_began(stand: Stand) -> None:
    run = coordinator(stand, stand.driving())
    end = stand.finish(run, {1: lambda: run.request(Request.RESTORE)})
    assert (end.outcome, end.fails) == ("Success", 1)
