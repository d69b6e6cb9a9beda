"""Maps on which robots are set down anywhere: shipped ones, generated ones, and others from a folder."""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
import yaml
from PIL import Image

from benchmarks.driving.worlds.office_map import office_boxes
from handcart.backends.loading.robot_loading import load_robot
from handcart.evaluation.trials.rig import RigFiles
from handcart.primitives.knowledge.place import load_map
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes
from handcart.robotics.numerics.arrays import IntArray

ROOT = Path(__file__).resolve().parents[3]
SHIPPED = ("drive_map/map.yaml", "drive_map/twin_rooms.yaml", "return_book/map.yaml")
OFFICE_SIZE_M = (22.0, 14.0)
CORRIDOR_M = (30.0, 2.4)
ROOM_M = 0.12  # beside the footprint, where a robot is set down
HEADER = (
    "image: {name}.png\nresolution: {cell}\norigin: [0, 0, 0]\nnegate: 0\n"
    "occupied_thresh: 0.65\nfree_thresh: 0.196\n"
)


class Chart(NamedTuple):
    """A map with the places where a robot can be set down."""

    name: str
    path: Path
    grid: GridMap
    cells: IntArray
    """(n, 2) free cells with room for the robot, all connected."""

    def pose(self, rng: np.random.Generator) -> Pose2:
        """Return a random pose."""
        x, y = self.grid.to_point(self.cells[rng.integers(len(self.cells))][None])[0]
        x, y = x + rng.uniform(-0.02, 0.02), y + rng.uniform(-0.02, 0.02)
        return Pose2(float(x), float(y), float(rng.uniform(-math.pi, math.pi)))


def start_options(description: str | None, runs: int) -> argparse.ArgumentParser:
    """Return a parser of the options that benchmarks on these maps share.

    Args:
        description: of the benchmark.
        runs: default number of runs.
    """
    words = argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    words.add_argument("--runs", type=int, default=runs, help="over all maps")
    words.add_argument("--first", type=int, default=0, help="the first seed")
    words.add_argument("--map", default="", help="only maps with this word in their name")
    words.add_argument("--backend", choices=["kinematic", "mujoco", "pybullet"], default="kinematic")
    words.add_argument("--robot", default="cart")
    words.add_argument("--maps", type=Path, help="folder with more maps in ROS format (default: none)")
    words.add_argument("--verbose", action="store_true", help="a line for each run")
    return words


def chosen_charts(folder: Path, chosen: argparse.Namespace) -> list[Chart]:
    """Return the maps that `start_options` chose; generated ones are written into a folder."""
    radius = load_robot(chosen.robot).footprint_radius_m
    if chosen.maps is None:
        print("maps of real buildings are skipped: no --maps FOLDER", flush=True)
    elif not (listed := map_files(chosen.maps)):
        raise SystemExit(f"--maps {chosen.maps}: no map in ROS format is there; needed: *.yaml with `image`")
    else:
        print(f"maps of {chosen.maps}: {', '.join(path.stem for path in listed)}", flush=True)
    return [chart for chart in charts(folder, radius, chosen.maps) if chosen.map in chart.name]


def map_files(folder: Path) -> list[Path]:
    """Return the map files in ROS format in a folder and below, by name."""
    found = sorted(folder.rglob("*.yaml"))
    return [path for path in found if "image:" in path.read_text(encoding="utf-8", errors="replace")]


def charts(folder: Path, radius: float, maps: Path | None = None) -> Iterator[Chart]:
    """Yield all maps; generated ones are written into a folder.

    Args:
        folder: for generated maps.
        radius: of the robot's footprint, in [m].
        maps: folder with more maps.
    """
    for name in SHIPPED:
        yield _chart(name.removesuffix(".yaml"), ROOT / "tasks" / name, radius)
    for seed in (1, 2):
        grid = from_boxes(office_boxes(seed, OFFICE_SIZE_M), 0.05, (0.0, 0.0), OFFICE_SIZE_M)
        yield _chart(f"office {seed}", _written(folder, f"office_{seed}", grid), radius)
    length, width = CORRIDOR_M
    sides = [(0.5 * length, y, 0.0, length, 0.1) for y in (0.05, width - 0.05)]
    ends = [(x, 0.5 * width, 0.0, 0.1, width) for x in (0.05, length - 0.05)]
    niches = [(7.0, width - 0.25, 0.0, 0.5, 0.4), (19.0, 0.25, 0.0, 1.2, 0.3)]
    corridor = from_boxes([*sides, *ends, *niches], 0.05, (0.0, 0.0), CORRIDOR_M)
    yield _chart("corridor", _written(folder, "corridor", corridor), radius)
    for path in [] if maps is None else map_files(maps):
        yield _chart(path.stem if path.stem != "map" else path.parent.name, path.resolve(), radius)


def _chart(name: str, path: Path, radius: float) -> Chart:
    grid = load_map(path)[0]
    free = np.pad(~grid.blocked, 1).astype(np.uint8)
    clear = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1]
    labels = cv2.connectedComponents((clear * grid.resolution > radius + ROOM_M).astype(np.uint8))[1]
    largest = 1 + int(np.argmax(np.bincount(labels.ravel())[1:]))
    return Chart(name, path, grid, np.argwhere(labels == largest))


def _written(folder: Path, name: str, grid: GridMap) -> Path:
    cells = np.where(grid.occupied, 0, 254).astype(np.uint8)[::-1]
    Image.fromarray(cells).save(folder / f"{name}.png")
    path = folder / f"{name}.yaml"
    path.write_text(HEADER.format(name=name, cell=grid.resolution), encoding="utf-8")
    return path


def written_world(
    folder: Path, chart: Chart, start: Pose2, places: dict[str, Pose2] | None = None, **more: Any
) -> RigFiles:
    """Write a world made from a map, and places on it, and return the files of a rig.

    Args:
        folder: where they are written.
        chart: the map.
        start: world_T_base at first.
        places: places by name; the first one is where the robot is told to start.
        more: further keys of the world's file.
    """
    world = {"format": "handcart-world/1", "map": str(chart.path), "start": floor_pose(start), **more}
    (folder / "world.yaml").write_text(yaml.safe_dump(world), encoding="utf-8")
    if not places:
        return RigFiles(folder / "world.yaml", chart.path, None, {}, "")
    listed = {name: floor_pose(pose) for name, pose in places.items()}
    text = json.dumps({"format": "handcart-places/1", "places": listed})
    (folder / "places.yaml").write_text(text, encoding="utf-8")
    return RigFiles(folder / "world.yaml", chart.path, folder / "places.yaml", {}, next(iter(places)))


def floor_pose(pose: Pose2) -> dict[str, float]:
    """Return a pose as files have it."""
    x, y, turn = round(pose.x, 4), round(pose.y, 4), round(math.degrees(pose.theta), 3)
    return {"x_m": x, "y_m": y, "heading_deg": turn}
