"""EXPLORE with computations in a thread, as on a real robot: nothing else touches the map meanwhile."""

from __future__ import annotations

from collections.abc import Callable, Generator
from pathlib import Path
from typing import Any

import pytest

from handcart.evaluation.trials.rig import Rig, build_rig
from handcart.primitives.contract.attempt import attempt
from handcart.primitives.driving.exploring import exploring_look
from handcart.primitives.driving.exploring.explore import Explore
from handcart.primitives.driving.exploring.exploring_look import ExploringLook
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.outcomes.outcome import Fail
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.exploring.frontiers import find_border
from handcart.robotics.navigation.exploring.growing_map import GrowingMap
from tests.primitives.driving.exploring.test_explore import TWO_ROOMS, truth_of, world

THREAD_S = 2.5  # that a computation takes


class Threads:
    """Computations that run on while the robot's time passes, whether or not anything waits for them."""

    def __init__(self, rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
        self.running: list[tuple[float, Callable[[], None]]] = []
        self._rig, self._step, add = rig, rig.robot.step, GrowingMap.add

        def watched_add(grown: GrowingMap, *args: Any) -> None:
            assert not self.running, "a keyframe was added while a thread works on the map"
            add(grown, *args)

        monkeypatch.setattr(GrowingMap, "add", watched_add)
        monkeypatch.setattr(rig.robot, "compute", self.compute)
        monkeypatch.setattr(rig.robot, "step", self.step)

    def compute(self, work: Callable[..., Any], *args: Any, takes: float = 0.0) -> Generator[None, None, Any]:
        """Stand in for `Robot.compute` of a real robot."""
        done: list[Any] = []
        self.running.append((self._rig.robot.time + THREAD_S, lambda: done.append(work(*args))))
        while not done:
            yield
        return done[0]

    def step(self, paused: bool = False) -> None:
        """Pass a period, and end the computations whose time is over."""
        self._step(paused)
        for row in [row for row in self.running if row[0] <= self._rig.robot.time]:
            row[1]()
            self.running.remove(row)


def rolled(rig: Rig) -> float:
    travel = rig.robot.localization.travel
    return 0.5 * (travel.left + travel.right)


@pytest.mark.slow
def test_restoring_waits_for_the_thread_that_draws_the_map(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is cancelled while the base drives, and keyframes wait for the thread."""
    with build_rig(world(tmp_path, TWO_ROOMS), robot="cart") as rig:
        threads, begun, made = Threads(rig, monkeypatch), truth_of(rig), Explore()
        periods = attempt(made, rig.robot, rig.model)
        since = rolled(rig)
        while not threads.running or rolled(rig) < since + 0.7:
            since = since if threads.running else rolled(rig)
            next(periods)
            rig.robot.step()
        periods.throw(Discrepancy("cancelled by request", cause=causes.CANCELLED))
        with pytest.raises(StopIteration) as end:
            while True:
                rig.robot.step()
                next(periods)
        outcome = end.value.value
        assert isinstance(outcome, Fail), outcome
        assert outcome.cause is causes.CANCELLED
        assert truth_of(rig).distance(begun) < 0.025
        assert "explored" in made.evidence.maps


def test_frontier_left_while_the_map_is_drawn_counts_next_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A drive fails for good while a thread draws: that frontier is left from the next look on."""
    with build_rig(world(tmp_path, TWO_ROOMS), robot="cart") as rig:
        made = Explore()
        for _ in zip(range(200), attempt(made, rig.robot, rig.model), strict=False):
            if made._look is not None:
                break
            rig.robot.step()
        look = made._look
        assert isinstance(look, ExploringLook)
        first = look.take(Pose2(0.0, 0.0, 0.0), None)
        assert first.target is not None
        middle = first.target.middle

        def leaving(*args: Any) -> Any:
            border = find_border(*args)
            look.leave(middle, "no_route")
            return border

        monkeypatch.setattr(exploring_look, "find_border", leaving)
        meanwhile = look.take(Pose2(0.0, 0.0, 0.0), None)
        monkeypatch.undo()
        assert "without a route" not in str(meanwhile.facts["unknown_border"])
        after = look.take(Pose2(0.0, 0.0, 0.0), None)
        assert "without a route" in str(after.facts["unknown_border"])
