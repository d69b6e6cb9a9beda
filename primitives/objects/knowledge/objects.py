"""World model section of objects."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

from typing_extensions import override

from handcart.files.models.loading import Loaded, load_document
from handcart.files.suggest import suggest
from handcart.files.yaml.yaml_document import read_document
from handcart.primitives.detectors.detector import BrokenDetector, Detector, make_detector
from handcart.primitives.knowledge.place import Place
from handcart.primitives.knowledge.section import MovedKnowledge, NamedFiles, Section
from handcart.primitives.objects.files.object_findings import gripper_findings
from handcart.primitives.objects.files.objects_file import ObjectsFile
from handcart.primitives.objects.files.surface import ObjectSurface
from handcart.robotics.geometry.footprint import polygon_gap
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.maps.map_boxes import boxes_near
from handcart.robotics.navigation.maps.movable_areas import MovableArea
from handcart.robotics.navigation.maps.moved_things import MovedThing
from handcart.robotics.numerics.arrays import FloatArray

from .grasp_reach import missed_words
from .hiding_areas import KnownSurface, hiding_areas
from .surface_places import NoStandingPlace, followed_place, has_moved, standing_place
from .surface_scan import is_in_scan, scan_surface
from .tag_sight import unread_words

if TYPE_CHECKING:
    from handcart.backends.description.robot_file import RobotFile
    from handcart.backends.robot.robot import Robot
    from handcart.files.errors import Finding

FOOT_OFF_M = 0.02  # that a foot may be off where it was seen, or is to be put
BELIEVED_OFF_M = 0.05  # likewise where it was not seen yet
LEVEL_M = 0.002  # between the heights of surfaces that one object stands on
JOINED_M = 0.05  # between two surfaces, below which they are one body to a lidar
WALL_NAME = "what the map shows"
MOST_WALLS, MOST_CERTAIN_WALLS = 60, 400  # more of them would be drawn as larger blocks
UNSURE_CELLS = 0.9  # of a wall's thickness: half of the outermost cell on each side, and not quite all of one
WALL_REACH_M = 1.4  # from the base, within which an arm may touch what is on the map
WALL_HEIGHT_M = 2.4
EDGE_CELLS = 1.5  # of the map, around a surface, that its own edge is drawn in
NOTHING_KNOWN = ObjectsFile(format="handcart-objects/1", kinds={}, surfaces={})


class ObjectSighting(NamedTuple):
    """Object as it was last seen: the surface on which it was, and its pose on the map with covariance."""

    object: str
    surface: str
    pose: Pose2
    """Pose of the object on the map."""
    covariance: tuple[tuple[float, ...], ...]
    """(3, 3) of x, y in [m] and heading in [rad], with the uncertainty of the base's pose."""


class SurfacePose(NamedTuple):
    """Last measured pose of a surface, and its accuracy; the base was at rest in front of the surface."""

    surface: str
    pose: Pose2
    """Pose of the middle of the surface's top, on the map."""
    covariance: tuple[tuple[float, ...], ...]
    """(3, 3) of x, y in [m] and heading in [rad], without the uncertainty of the base's pose."""


class HeldObject(NamedTuple):
    """Object that the hand holds, with its pose in the hand frame."""

    object: str
    hand_T_object: Transform
    """(4, 4); the object's origin is in the middle of its foot."""


@dataclass
class Objects(Section):
    """Section of a world model with the objects and surfaces of a file, and where they were seen last."""

    FILES: ClassVar = {"objects": ObjectsFile}
    LEARNED: ClassVar = ("sightings", "held_object", "surface_poses", "handed_over")
    ADDED: ClassVar = ("handed_over",)

    objects: ObjectsFile = NOTHING_KNOWN
    """Kinds, objects and surfaces."""
    sightings: tuple[ObjectSighting, ...] = ()
    """Objects as they were last seen, each once."""
    held_object: HeldObject | None = None
    """The object in the hand."""
    surface_poses: tuple[SurfacePose, ...] = ()
    """Surfaces as they were measured last, each once."""
    handed_over: tuple[str, ...] = ()
    """Names of objects that a person took out of the hand, each once."""
    listed: Loaded[ObjectsFile] | None = field(default=None, repr=False, compare=False)
    """The file with the lines of its values."""
    detectors: Mapping[str, Detector] = field(default_factory=dict, repr=False, compare=False)
    """Detectors of other packages, by name."""
    stands: Mapping[str, Place] = field(default_factory=dict, repr=False, compare=False)
    """Computed places of the base, by surface."""
    remarks: Sequence[tuple[str, str]] = field(default=(), repr=False, compare=False)
    """Warnings before a run, each with the name of the object that it is about."""

    @override
    @classmethod
    def load(cls, files: NamedFiles) -> Self:
        listed = files.read("objects", lambda path: load_document(read_document(path), ObjectsFile))
        if listed is None:
            return cls()
        return cls(listed.value, listed=listed, detectors=_built(listed, files))

    @override
    def faults(self, robot: RobotFile) -> Iterator[Finding]:
        """Yield a finding for each kind of object that is too wide for the opening of the gripper."""
        if self.listed is not None and robot.gripper is not None:
            yield from gripper_findings(self.listed.document, self.objects.kinds, robot.gripper.opening_mm)

    @override
    def names(self) -> Mapping[str, Collection[object] | None]:
        if self.listed is None:
            return {"places": None}
        surfaces = self.objects.surfaces
        computed = [name for name, surface in surfaces.items() if surface.place is None]
        spots = list(dict.fromkeys(spot for surface in surfaces.values() for spot in surface.spots))
        return {"objects": self.objects.objects, "surfaces": surfaces, "spots": spots, "places": computed}

    @override
    def fit(self, robot: RobotFile, grid: GridMap, places: Mapping[str, Place]) -> Iterator[Finding]:
        if self.listed is None:
            return
        found: dict[str, Place] = {}
        by_hand = {name: surface.place for name, surface in self.objects.surfaces.items() if surface.place}
        given = {name: places[place] for name, place in by_hand.items() if place in places}
        for name, surface in self.objects.surfaces.items():
            if surface.place is not None:
                if surface.place not in places:
                    words = f"unknown place {surface.place!r}{suggest(surface.place, places)}"
                    yield self.listed.finding(("surfaces", name, "place"), words)
            elif robot.arm is not None and robot.gripper is not None:
                try:
                    found[name] = standing_place(robot, grid, self.objects, name, tuple(places.values()))
                except NoStandingPlace as reason:
                    yield self.listed.finding(("surfaces", name), str(reason), at_key=True)
        self.stands = found
        if robot.arm is not None and robot.gripper is not None:
            stands = {**given, **found}
            self.remarks = [
                *missed_words(robot, self.objects, stands),
                *unread_words(robot, self.objects, stands),
            ]

    @override
    def warnings(self) -> Iterator[Finding]:
        if self.listed is not None:
            for name, words in self.remarks:
                yield self.listed.finding(("objects", name), words, at_key=True)

    @override
    def places(self) -> Mapping[str, Place]:
        return self.stands

    @override
    def movable_areas(self) -> Iterator[MovableArea]:
        areas = (surface.movable_area() for surface in self.objects.surfaces.values())
        return (area for area in areas if area is not None)

    @override
    def moved_things(self) -> Iterator[MovedThing]:
        for name, surface in self.objects.surfaces.items():
            now = self.surface(name)
            if has_moved(surface, now):
                yield MovedThing(surface.outline, now.outline)

    @override
    def measuring(
        self, robot: Robot, model: MovedKnowledge, place: str, report: Callable[..., None]
    ) -> Generator[None, None, bool] | None:
        """Return a generator that measures, by lidar, the surface for which `place` is the base's place.

        The generator moves the place with the surface, and returns True if the surface was seen. The result
        is None if the place was not computed from a surface, or if the surface is fixed, was measured before
        or cannot be seen by the lidar.
        """
        surface = self.objects.surfaces.get(place)
        measured = any(pose.surface == place for pose in self.surface_poses)
        if surface is None or place not in self.stands or surface.fixed or measured:
            return None
        if not self._is_measurable(robot, surface):
            return None
        return self.measure(robot, model, place, report)

    def _is_measurable(self, robot: Robot, surface: ObjectSurface) -> bool:
        """Return whether the lidar sees where a surface ends: no other one that it sees joins it."""
        others = [other for other in self.objects.surfaces.values() if other is not surface]
        return is_in_scan(robot, surface) and not any(
            is_in_scan(robot, other) and polygon_gap(surface.outline, other.outline) < JOINED_M
            for other in others
        )

    def measure(
        self, robot: Robot, model: MovedKnowledge, name: str, report: Callable[..., None]
    ) -> Generator[None, None, bool]:
        """Measure the pose of a surface by lidar and keep it in this section; return whether it was seen.

        A surface that the lidar does not see keeps the pose of its file. After the measurement, distance and
        turn between base and surface are known better than the base's pose on the map. The base's place in
        front of the surface, if it was computed, moves with the surface.

        Args:
            robot: robot before the surface.
            model: its map and places are changed if the surface has moved.
            name: name of the surface.
            report: receives the metrics `surface_off_mm` and `surface_off_deg`.
        """
        surface = self.objects.surfaces.get(name)
        if surface is None or not self._is_measurable(robot, surface):
            return False
        before = self.surface(name)
        found = yield from scan_surface(robot, surface)
        others = tuple(pose for pose in self.surface_poses if pose.surface != name)
        if found is None:
            self.surface_poses = others
        else:
            pose, covariance = found
            noted = SurfacePose(name, pose, tuple(tuple(row) for row in covariance.tolist()))
            self.surface_poses = (*others, noted)
            report(
                surface_off_mm=round(1e3 * pose.distance(surface.floor), 1),
                surface_off_deg=round(math.degrees(pose.turn(surface.floor)), 2),
            )
        if has_moved(before, self.surface(name)):
            yield from self._move_place(robot, model, name)
        return found is not None

    def _move_place(self, robot: Robot, model: MovedKnowledge, name: str) -> Generator[None, None, None]:
        """Draw a surface where it is now, and move its computed place with it if there is room."""
        grid, stand = model.redraw_moved(), self.stands.get(name)
        if stand is None:
            return
        others = tuple(place for key, place in model.places.items() if key != name)
        place = yield from robot.compute(
            followed_place,
            robot.spec,
            grid,
            self.objects.surfaces[name],
            self.surface(name),
            stand,
            others,
        )
        model.places = {**model.places, name: place}

    def seen(self, name: str) -> ObjectSighting | None:
        """Return where the object `name` was last seen; None if it was not seen in this run."""
        return next((sighting for sighting in self.sightings if sighting.object == name), None)

    def surface(self, name: str) -> ObjectSurface:
        """Return a surface of the file of objects by its name, at its measured pose if it was measured."""
        surface = self.objects.surfaces[name]
        measured = next((pose.pose for pose in self.surface_poses if pose.surface == name), None)
        return surface if measured is None else surface.moved_to(measured)

    def walls_near(
        self,
        grid: GridMap,
        point: Pose2,
        open_areas: Sequence[FloatArray] = (),
        certain: bool = False,
        seen_from: float = 0.0,
    ) -> list[Box]:
        """Return boxes, posed on the map, for a map's obstacles within `WALL_REACH_M` of a point.

        Furniture that is a surface of the objects file is left out, but not what stands on a surface that the
        lidar sees over. The map doesn't show how high obstacles are: the boxes are higher than an arm
        reaches.

        Args:
            grid: the map.
            point: pose of the base on the map.
            open_areas: outlines (n, 2) on the map, in [m], of further areas whose obstacles are left out.
            certain: True for boxes that end within their outermost cells, where an obstacle's surface may be
                anywhere; False for boxes around these cells.
            seen_from: height of the lidar above the floor, in [m]; 0 without one.
        """
        known = [
            KnownSurface(surface, self.surface(name), self._feet_on(name))
            for name, surface in self.objects.surfaces.items()
        ]
        outlines = hiding_areas(known, grid, seen_from)
        margin = EDGE_CELLS * grid.resolution
        most, less = (MOST_CERTAIN_WALLS, UNSURE_CELLS * grid.resolution) if certain else (MOST_WALLS, 0.0)
        around = (point.x, point.y), WALL_REACH_M
        found = boxes_near(grid, *around, [*open_areas, *outlines], margin, most)
        return [
            Box(
                transform((box.x, box.y, WALL_HEIGHT_M / 2)),
                (box.length - less, box.width - less, WALL_HEIGHT_M),
                WALL_NAME,
            )
            for box in found
        ]

    def _feet_on(self, surface: str) -> list[tuple[float, Pose2 | None]]:
        """Return where the foot of each object is that should be on a surface; see `KnownSurface.feet`."""
        found = []
        for name, item in self.objects.objects.items():
            sighted = self.seen(name)
            if (item.on if sighted is None else sighted.surface) == surface:
                pose, off = (self.believed(name), BELIEVED_OFF_M) if sighted is None else (sighted.pose, 0.0)
                found.append((self.objects.kinds[item.kind].foot_radius + off, pose))
        return found

    def touched_names(self, name: str, x: float, y: float, radius: float) -> tuple[str, ...]:
        """Return the names by which contacts are reported for all surfaces that an object on a surface
        touches.

        These are the surface itself, and surfaces of the same height that the object's foot may reach onto.

        Args:
            name: name of the surface.
            x: x of the foot's middle on the map, in [m].
            y: y of the foot's middle on the map, in [m].
            radius: radius of the circle around the foot, in [m].
        """
        surface = self.surface(name)
        others = ((other, self.surface(other)) for other in self.objects.surfaces if other != name)
        level = [item for item in others if abs(item[1].height_m - surface.height_m) < LEVEL_M]
        least = -(radius + FOOT_OFF_M)
        reached = (other for other, beside in level if beside.margin(x, y) > least)
        return (*surface.contact_names(name), *reached)

    def believed(self, name: str) -> Pose2 | None:
        """Return the pose on the map that the file of objects states for an object. If the object's surface
        was measured elsewhere, the pose is moved with the surface. The result is None if the object may be
        anywhere on the surface.
        """
        known = self.objects.objects[name]
        if known.x_m is None or known.y_m is None:
            return None
        pose = Pose2(known.x_m, known.y_m, math.radians(known.heading_deg))
        before, now = self.objects.surfaces[known.on].floor, self.surface(known.on).floor
        return pose if now == before else now.compose(pose.relative_to(before))

    def without(self, name: str) -> tuple[ObjectSighting, ...]:
        """Return the sightings of all objects but the one named `name`."""
        return tuple(sighting for sighting in self.sightings if sighting.object != name)

    def is_taken_away(self, name: str) -> bool:
        """Return whether an object is not where the file states: it is in the hand, or a person has it."""
        held = self.held_object
        return name in self.handed_over or (held is not None and held.object == name)

    @override
    def noted(self) -> dict[str, Any]:
        held = self.held_object
        return {
            "sightings": [
                [*sighting[:2], list(sighting.pose), sighting.covariance] for sighting in self.sightings
            ],
            "surface_poses": [
                [pose.surface, list(pose.pose), pose.covariance] for pose in self.surface_poses
            ],
            "held_object": None if held is None else [held.object, held.hand_T_object.round(6).tolist()],
            "handed_over": list(self.handed_over),
        }


def _built(listed: Loaded[ObjectsFile], files: NamedFiles) -> dict[str, Detector]:
    """Return the detectors that a file names; add what is wrong with one to the findings."""
    file, built = listed.value, {}
    for name, options in file.detectors.items():
        try:
            built[name] = make_detector(name, file.solids(), options, files.paths["objects"].parent)
        except BrokenDetector as broken:
            files.findings.add(listed.finding(("detectors", name), str(broken), at_key=True))
    return built
