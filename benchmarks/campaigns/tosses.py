"""Rare ends that are known exactly: of walks, and of runs whose primitive fails as often as noise says."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import ClassVar

from scipy.stats import norm

from benchmarks.campaigns.walk import walk
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, NeedsPerson

MAP_FOLDER = Path(__file__).parents[2] / "tasks" / "drive_map"
NETWORK_TEXT = """\
actions:
  - {do: MOVE_TO, from: at_home, to: between, cost_s: 20, p: 0.95, p_give_up: AT_ONCE, with: {place: shelf_1}}
  - {do: MOVE_TO, from: at_home, to: between, cost_s: 500, attempts: 1, p: 0.1, p_give_up: 0.9,
     with: {place: shelf_5}}
  - {do: MOVE_TO, from: between, to: at_shelf, cost_s: 30, attempts: 3, p: 0.95, with: {place: shelf_3}}
"""
TASK_TEXT = """\
format: handcart-task/1
title: Toss until it succeeds
robot: cart
world: {parameter: map}
knowledge: {map: map.yaml, places: places.yaml, start: home}
parameters: {map: map.yaml, likely: 0.1}
start: before
goal: after
situations: {before: {}, after: {}}
actions:
  - {do: TOSS, from: before, to: after, cost_s: 1, attempts: 3, with: {fails: {parameter: likely}}}
  - {do: TOSS, from: before, to: after, cost_s: 50, attempts: 1,
     with: {fails: {parameter: likely}, last: true}}
"""
TOSS_PRIMITIVE = {"TOSS": "benchmarks.campaigns.tosses:Toss"}


class Toss(ActionPrimitive):
    """Fails by the noise of two readings of one beam; the last one gives up instead."""

    fails: float
    """Probability of a Fail."""
    last: bool = False
    needs: ClassVar = (RangeSensor,)

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        yield
        before = robot.range_sensor.scan().ranges[90]
        yield
        assert robot.spec.range_sensor is not None
        sigma = 2.0**0.5 * robot.spec.range_sensor.sigma_mm / 1e3
        if robot.range_sensor.scan().ranges[90] - before > sigma * norm.ppf(1.0 - self.fails):
            raise (
                NeedsPerson("the last one, too", cause=causes.MISPLACED)
                if self.last
                else Discrepancy("it fell on the wrong side", cause=causes.MISPLACED)
            )


def rare_walk(folder: Path, at_once: float = 0.0) -> Path:
    """Return the file of a task whose walks give up once in about 10,000: after three Fails.

    Args:
        folder: exists.
        at_once: how often the first action gives up beside that, with no Fail before.
    """
    path = walk(folder)
    text = path.read_text(encoding="utf-8")
    actions = NETWORK_TEXT.replace("AT_ONCE", str(at_once))
    path.write_text(text[: text.index("actions:")] + actions, encoding="utf-8")
    return path


def tosses(folder: Path) -> Path:
    """Write a task whose runs give up after four failed tosses; `TOSS_PRIMITIVE` has to be registered."""
    for name in ("map.yaml", "map.png", "places.yaml"):
        shutil.copy(MAP_FOLDER / name, folder / name)
    path = folder / "tosses.yaml"
    path.write_text(TASK_TEXT, encoding="utf-8")
    return path
