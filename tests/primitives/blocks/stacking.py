"""A robot with blocks at the stacking table, to try single primitives on."""

from __future__ import annotations

from pathlib import Path

from handcart.evaluation.trials.rig import Rig, RigFiles, build_rig
from handcart.primitives.blocks.fixate import Fixate
from handcart.primitives.blocks.pick_up_block import PickUpBlock
from handcart.primitives.outcomes.outcome import Success
from tests.primitives.changed_scene import scene_of as scene_of

TASK = Path(__file__).parents[3] / "tasks" / "stack_blocks"


def at_the_wall(
    world: Path = TASK / "unload_world.yaml",
    robot: str = "toyama/h1",
    seed: int = 0,
    building: Path = TASK / "building.yaml",
) -> Rig:
    """Return a rig with the robot near its place at the wall and five blocks on its own table."""
    files = RigFiles(world, TASK / "map.yaml", TASK / "places.yaml", {"building": building}, "stacking")
    return build_rig(files, robot=robot, seed=seed)


def with_block(rig: Rig, number: int = 1) -> Rig:
    """The landmark was seen, and the hand holds a block."""
    for primitive in (Fixate(landmark="stacking"), PickUpBlock(number=number, at="robot")):
        assert isinstance(rig.do(primitive), Success)
    return rig
