"""World in the page: solids, things, map, and the robot's scans, estimates and plans."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from handcart.evaluation.viewing.drawing.track_lines import track_lines
from handcart.evaluation.viewing.playback.scenery import (
    FREE,
    OCCUPIED,
    MapShape,
    Scenery,
    SolidShape,
    ThingShape,
)
from handcart.evaluation.viewing.playback.seven import seven, sevens, transforms
from handcart.robotics.numerics.arrays import BoolArray, ByteArray, FloatArray, SingleArray

from . import colours
from .boxes import add_boxes
from .colours import Rgb

if TYPE_CHECKING:
    import viser

SEE_THROUGH_HEIGHT_M = 1.6  # higher solids are drawn transparent
SEE_THROUGH_OPACITY = 0.28
ON_MAP = "/on_map"  # node of what is known in the map's frame
TRACK_HEIGHT_M = 0.05  # of the tracks of people
LINE_HEIGHT_M = 0.015  # of lines above the floor
ELLIPSE_CORNERS = 48
ELLIPSE_SIGMAS = 3.0
RAISED_HEIGHT_M = 0.3  # of a map's occupied cells, where no solids are known


class WorldNodes:
    """Drawing of the robot's surroundings, and of its lidar rays, planned route and driven path."""

    def __init__(self, server: viser.ViserServer, scenery: Scenery, things: Iterable[ThingShape]) -> None:
        """Draw the scenery; a thing is invisible until it has a pose."""
        self._server, self._scene = server, server.scene
        self._passing: list[tuple[SolidShape, Any]] = []
        self._things: dict[str, tuple[Any, FloatArray]] = {}
        self._at: dict[str, FloatArray | None] = {}
        self._ground(scenery)
        x, y, heading = scenery.world_t_map
        turn = (math.cos(0.5 * heading), 0.0, 0.0, math.sin(0.5 * heading))
        self._scene.add_frame(ON_MAP, wxyz=turn, position=(x, y, 0.0), show_axes=False)
        if scenery.map is not None:
            self._map(scenery.map, raised=not scenery.simulated)
        self._solids(scenery.solids)
        for thing in things:
            self.add_thing(thing)
        for name, (x, y, _) in scenery.places.items():
            self._scene.add_label(
                f"{ON_MAP}/places/{name}", name, position=(x, y, 0.05), font_screen_scale=0.8
            )
        none = np.zeros((0, 2, 3), np.float32)
        self.rays = self._lines("/rays", none, colours.RAY_RGB, 0.003)
        self.hits = self._points("/hits", colours.HIT_RGB, 0.025)
        self.bumped = self._points(f"{ON_MAP}/bumped", colours.BUMPED_RGB, 0.04)
        self.planned = self._lines(f"{ON_MAP}/planned", none, colours.PLANNED_RGB, 0.015)
        self.people = self._lines(f"{ON_MAP}/people", none, colours.PEOPLE_RGB, 0.02)
        self.driven = self._lines("/driven", none, colours.DRIVEN_RGB, 0.012)
        self.restored = self._lines("/restored", none, colours.RESTORED_RGB, 0.015)
        self.ellipse = self._lines(f"{ON_MAP}/ellipse", none, colours.CLOUD_RGB, 0.015)
        self.cloud = self._points(f"{ON_MAP}/cloud", colours.CLOUD_RGB, 0.04)

    # Moving nodes

    def add_thing(self, shape: ThingShape) -> None:
        """Add an invisible movable thing; an existing thing of this name is unchanged."""
        if shape.name in self._things:
            return
        middle = transforms(np.array([shape.middle]))[0]
        colour = colours.of_thing(shape.name, shape.grey)
        box = self._scene.add_box(
            f"/things/{shape.name}", color=colour, dimensions=shape.size_m, visible=False
        )
        self._things[shape.name] = (box, middle)

    def place(self, poses: Mapping[str, FloatArray | None]) -> None:
        """Move things to their poses world_T_thing (7,): x, y, z in [m], and a unit quaternion w, x, y, z.

        A thing whose pose is None is hidden.
        """
        for name, pose in poses.items():
            if name in self._at and _same(self._at[name], pose):
                continue
            self._at[name] = pose
            box, middle = self._things[name]
            if pose is None:
                box.visible = False
                continue
            at = sevens((transforms(pose[None])[0] @ middle)[None])[0]
            box.position, box.wxyz, box.visible = at[:3], at[3:], True

    def come_and_go(self, world_time: float) -> None:
        """Show the obstacles present at `world_time` [s], and hide those that appear later or have left."""
        for solid, box in self._passing:
            there = solid.appears_s <= world_time < (np.inf if solid.leaves_s is None else solid.leaves_s)
            if box.visible != there:
                box.visible = there

    def estimate(self, pose: FloatArray, covariance: FloatArray) -> None:
        """Draw the ellipse of three standard deviations around the estimated base pose.

        Args:
            pose: (3,) map_T_base: x, y in [m] and heading in [rad].
            covariance: (3, 3) of the pose, along the map's axes, of x, y in [m] and heading in [rad].
        """
        values, vectors = np.linalg.eigh(covariance[:2, :2].astype(np.float64))
        angle = np.linspace(0.0, 2.0 * np.pi, ELLIPSE_CORNERS + 1)
        unit = np.stack((np.cos(angle), np.sin(angle)))
        radii = ELLIPSE_SIGMAS * np.sqrt(np.clip(values, 0.0, None))
        if not np.isfinite(radii).all():
            radii = np.zeros(2)
        self.draw(self.ellipse, (vectors @ (np.maximum(radii, 0.02)[:, None] * unit)).T + pose[:2])

    def track(self, rows: FloatArray) -> None:
        """Draw ellipses and velocities of tracked people.

        Args:
            rows: (p, 7) on the map, each x, y in [m], velocity x, y in [m/s], and xx, xy, yy of the
                covariance in [m²].
        """
        steps = [np.zeros((0, 2, 2)), *(np.stack((a[:-1], a[1:]), axis=1) for a in track_lines(rows))]
        flat = np.concatenate(steps)
        height = np.full((*flat.shape[:2], 1), TRACK_HEIGHT_M)
        self.people.points = np.concatenate((flat, height), axis=2).astype(np.float32)

    @staticmethod
    def draw(lines: Any, path: FloatArray, chosen: BoolArray | None = None) -> None:
        """Draw lines along a path.

        Args:
            lines: viser's node of the lines.
            path: (n, 2) on the map, in [m].
            chosen: mask (n - 1,), true for each segment between two points to draw; None: all.
        """
        points = np.column_stack((path, np.full(len(path), LINE_HEIGHT_M)))
        steps = np.stack((points[:-1], points[1:]), axis=1) if len(path) > 1 else np.zeros((0, 2, 3))
        lines.points = (steps if chosen is None else steps[chosen]).astype(np.float32)

    # Static nodes

    def _ground(self, scenery: Scenery) -> None:
        plane = colours.GROUND_RGB if scenery.outdoors else colours.FLOOR_RGB
        self._scene.add_grid(
            "/ground",
            infinite_grid=True,
            cell_size=1.0,
            section_size=5.0,
            cell_color=(206, 212, 219),
            section_color=(178, 186, 196),
            plane_color=plane,
            plane_opacity=1.0,
            position=(0.0, 0.0, -0.02),
            fade_distance=60.0,
        )

    def _map(self, shape: MapShape, raised: bool) -> None:
        picture = shape.picture()
        cell = shape.resolution_m
        height, width = picture.shape
        x0, y0 = shape.origin_m
        rgba = np.zeros((height, width, 4), np.uint8)
        rgba[picture == FREE] = (255, 255, 255, 150)
        rgba[picture == OCCUPIED] = (70, 78, 90, 200)
        middle = (x0 + width * cell / 2, y0 + height * cell / 2, -0.008)
        turned = seven(np.diag([1.0, -1.0, -1.0, 1.0]))  # a picture's y goes down
        self._scene.add_image(
            f"{ON_MAP}/map",
            rgba,
            width * cell,
            height * cell,
            format="png",
            wxyz=turned[3:],
            position=middle,
            cast_shadow=False,
        )
        if raised:
            add_boxes(self._scene, f"{ON_MAP}/map/raised", *_runs(shape, picture), colours.WALL_RGB, 1.0)

    def _solids(self, solids: Iterable[SolidShape]) -> None:
        passing = [shape for shape in solids if shape.appears_s > 0.0 or shape.leaves_s is not None]
        staying = [shape for shape in solids if shape not in passing]
        for number, solid in enumerate(passing):
            box = self._scene.add_box(
                f"/passing/{number}",
                color=(200, 96, 60),
                dimensions=solid.size_m,
                position=solid.pose[:3],
                wxyz=solid.pose[3:],
            )
            self._passing.append((solid, box))
        tall = [shape for shape in staying if shape.size_m[2] > SEE_THROUGH_HEIGHT_M]
        low = [shape for shape in staying if shape.size_m[2] <= SEE_THROUGH_HEIGHT_M]
        for name, chosen, opacity in (("/tall", tall, SEE_THROUGH_OPACITY), ("/solids", low, 1.0)):
            poses = np.array([item.pose for item in chosen]).reshape(-1, 7)
            sizes = np.array([item.size_m for item in chosen]).reshape(-1, 3)
            tints = [colours.WALL_RGB if opacity < 1.0 else colours.of_solid(item.grey) for item in chosen]
            add_boxes(self._scene, name, poses, sizes, np.array(tints, np.uint8), opacity)

    def _lines(self, name: str, points: SingleArray, colour: Rgb, thickness: float) -> Any:
        return self._scene.add_line_segments(name, points, colour, thickness=thickness)

    def _points(self, name: str, colour: Rgb, size: float) -> Any:
        none = np.zeros((0, 3), np.float32)
        return self._scene.add_point_cloud(
            name, none, colour, point_size=size, point_shape="circle", precision="float32"
        )


def _same(a: FloatArray | None, b: FloatArray | None) -> bool:
    return a is b or (a is not None and b is not None and np.array_equal(a, b))


def _runs(shape: MapShape, picture: ByteArray) -> tuple[FloatArray, FloatArray]:
    """Return boxes for the occupied cells of a map, one for each run in a row: poses (n, 7), sizes (n, 3)
    in [m].
    """
    cell, (x0, y0), height = shape.resolution_m, shape.origin_m, picture.shape[0]
    poses, sizes = [], []
    for row, cells in enumerate(picture == OCCUPIED):
        edges = np.flatnonzero(np.diff(np.concatenate(([0], cells.astype(np.int8), [0]))))
        for a, b in edges.reshape(-1, 2).tolist():
            y = y0 + (height - row - 0.5) * cell
            poses.append((x0 + (a + b) / 2 * cell, y, RAISED_HEIGHT_M / 2, 1.0, 0.0, 0.0, 0.0))
            sizes.append(((b - a) * cell, cell, RAISED_HEIGHT_M))
    return np.array(poses).reshape(-1, 7), np.array(sizes).reshape(-1, 3)
