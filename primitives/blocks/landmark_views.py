"""Identify the plan's landmarks by all pictures of a fixation together."""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from typing import NamedTuple

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.outcomes.evidence import Evidence
from handcart.primitives.restoring.snapshot import settle
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.manipulation.suspension.fixation import PlannedView
from handcart.robotics.numerics.arrays import BoolArray, ByteArray
from handcart.robotics.perception.drawing.overlay import draw_overlay
from handcart.robotics.perception.landmarks.constellation import (
    MIN_LOG_RATIO,
    STRAY_LOG_COST,
    UNSEEN_LOG_COST,
    BasePrior,
    Kind,
    MarkAssignment,
    PlannedMark,
    Sighting,
    explain,
    rivals,
)
from handcart.robotics.perception.landmarks.landmark import Landmark
from handcart.robotics.perception.landmarks.landmark_finder import find_landmarks
from handcart.robotics.perception.landmarks.landmark_in_view import wholly_in_view
from handcart.robotics.perception.landmarks.landmark_pose import planar_pose

NEARER, FARTHER = 0.05, 0.05  # [m] by which a landmark may be off its height in a picture
MIN_MARK_SPACING_M = 0.02  # minimum distance of two marks
SEARCH_STEP_M = 0.09  # between the views of a search: the picture shows 0.24 x 0.18 m
MAX_VIEW_STEPS = 6  # steps, to a view that separates two hypotheses
SAME_PX = 8.0  # between two finds of one mark in a picture


class Sought(NamedTuple):
    """Landmark to search for, with all landmarks that look alike, and the estimated pose of the base.

    All poses are relative to the base's target place.
    """

    mark: PlannedMark
    among: tuple[PlannedMark, ...]
    """All landmarks of the plan, the wanted `mark` included."""
    belief: BasePrior
    """Believed pose of the base."""


class _Seen(NamedTuple):
    landmark: Landmark
    at: Sighting


class _Difference(NamedTuple):
    rival: int
    """Index, among the other explanations, of the one that disagrees with the likeliest one."""
    place: Pose2
    """base_T_mark of the landmark that only one of the two explanations expects."""
    weight: float
    """Gain of the likeliest explanation's lead, in log-likelihood, if a view confirms it."""


class LandmarkViews:
    """Identification of landmarks, which all look alike, in the pictures of one fixation.

    A fixation measures the base's pose at a landmark. Several explanations are compared; each assigns every
    mark that was seen to a landmark of the plan. A mark is remembered until a picture that should show it
    does not. `frames` is the number of pictures taken.
    """

    def __init__(self, robot: Robot, view: PlannedView, sought: Sought, evidence: Evidence) -> None:
        self._robot, self._view, self._sought, self._evidence = robot, view, sought, evidence
        self._seen: list[_Seen] = []
        self._last: list[_Seen] = []
        self._cameras: list[Transform] = []
        self._explained: list[MarkAssignment] = []
        self._displaced = robot.localization.displacements
        self.frames = 0

    def look(self) -> Generator[None, None, None]:
        """Wait until the robot rests, take a picture, and assign all marks seen so far to landmarks again.

        A mark is the picture of a landmark that is not yet identified. If the base was moved since the last
        picture, marks in earlier pictures are forgotten.
        """
        robot = self._robot
        yield from settle(robot)
        yield
        photo = robot.photo()
        if robot.localization.displacements != self._displaced:
            self._seen, self._cameras, self._displaced = [], [], robot.localization.displacements
        camera = photo.base_T_camera
        self._last = self._found(photo.pixels, camera)
        self._evidence.pictures["landmark"] = draw_overlay(
            photo.pixels, landmarks=[item.landmark for item in self._last]
        )
        kept = [item for item in self._seen if not self._is_over(item, camera)]
        self._seen = kept + self._last
        self._cameras.append(camera)
        self.frames += 1
        sightings = [item.at for item in self._seen]
        self._explained = explain(self._sought.among, sightings, self._sought.belief, self._shown)

    @property
    def explanation(self) -> MarkAssignment | None:
        """Most likely assignment of seen marks to landmarks; None as long as no landmark was seen."""
        return self._explained[0] if self._explained else None

    @property
    def explanations(self) -> list[MarkAssignment]:
        """Most likely assignment of seen marks to landmarks, then others at most 5,000 times less likely,
        best first.

        The others are included only if they lead to another base pose than the most likely one.
        """
        return rivals(self._explained) if self._explained else []

    def wanted(self) -> Transform | None:
        """Return camera_T_landmark (4, 4) of the wanted landmark by the last picture.

        The camera's tilt and height over the landmark are assumed to be those of the planned view. None if
        the landmark is not visible.
        """
        if self.explanation is None:
            return None
        index = self._sought.among.index(self._sought.mark)
        for item, mark in zip(self._seen, self.explanation.marks, strict=True):
            if mark == index and any(item is last for last in self._last):
                plane = self._view.camera_T_landmark
                return np.asarray(plane @ planar_pose(item.landmark, plane).lift())
        return None

    def hides(self) -> bool:
        """Return whether the landmark that is searched is missing in the last picture although it should be
        in view.
        """
        if self.explanation is None or self.wanted() is not None:
            return False
        mark = self._sought.mark
        place = self.explanation.planned_T_base.inverse().compose(mark.place)
        return bool(self._inside(self._cameras[-1], mark.kind, [place])[0])

    def telling_hands(self, start: Transform) -> list[Transform]:
        """Return poses base_T_hand from which a picture can decide which assignment of seen marks to
        landmarks is right.

        The most informative one is first.

        Args:
            start: base_T_hand (4, 4); the poses are around it, at its height.
        """
        best, *others = self.explanations
        here = self._robot.base_T("hand")[:2, 3]
        differences = self._differences(best, others)
        lacks = np.array([other.score - best.score + MIN_LOG_RATIO for other in others])
        ranked = []
        for x, y in offsets(MAX_VIEW_STEPS):
            hand = start.copy()
            hand[:2, 3] += (x, y)
            gains = np.zeros(len(others))
            for kind, some in differences.items():
                camera = hand @ self._robot.camera.hand_T_camera
                inside = self._inside(camera, kind, [item.place for item in some])
                for item, seen in zip(some, inside, strict=True):
                    gains[item.rival] += item.weight * seen
            gain = float(np.minimum(gains, lacks).sum())
            if gain > 0.0:
                ranked.append((-gain, float(np.hypot(*(hand[:2, 3] - here))), hand))
        return [hand for _, _, hand in sorted(ranked, key=lambda item: item[:2])]

    def _differences(
        self, best: MarkAssignment, others: Sequence[MarkAssignment]
    ) -> dict[Kind, list[_Difference]]:
        """Return landmarks that only the best or only another explanation expects, where no picture was taken
        yet.
        """
        found: dict[Kind, list[_Difference]] = {}
        expected = self._expected(best)
        for rival, otherwise in enumerate(map(self._expected, others)):
            for ones, twos, weight in (
                (expected, otherwise, STRAY_LOG_COST),
                (otherwise, expected, UNSEEN_LOG_COST),
            ):
                for kind, places in ones.items():
                    for place, shown in zip(places, self._shown(kind, places), strict=True):
                        if not shown and all(
                            place.distance(item) > MIN_MARK_SPACING_M for item in twos[kind]
                        ):
                            found.setdefault(kind, []).append(_Difference(rival, place, weight))
        return found

    def _expected(self, explanation: MarkAssignment) -> dict[Kind, list[Pose2]]:
        """Return base_T_mark of all landmarks of the plan by an explanation, grouped by kind."""
        to_base = explanation.planned_T_base.inverse()
        places: dict[Kind, list[Pose2]] = {}
        for mark in self._sought.among:
            places.setdefault(mark.kind, []).append(to_base.compose(mark.place))
        return places

    def _found(self, image: ByteArray, base_T_camera: Transform) -> list[_Seen]:
        found: list[_Seen] = []
        for kind in {mark.kind: None for mark in self._sought.among}:
            camera_T_level = inverse(base_T_camera) @ Pose2(0.0, 0.0, 0.0).lift(kind.height)
            away = self._distance(base_T_camera, kind)
            span = (away - NEARER, away + FARTHER)
            for landmark in find_landmarks(image, self._robot.camera.model, kind.side, span):
                at = planar_pose(landmark, camera_T_level)
                same = [one for one in found if math.dist(one.landmark.centre, landmark.centre) < SAME_PX]
                if same:
                    found.remove(same[0])
                found.append(_Seen(landmark, {**(same[0].at if same else {}), kind: at}))
        return found

    def _distance(self, base_T_camera: Transform, kind: Kind) -> float:
        """Return the distance from the camera down to a landmark, in [m]; the wanted one's is as planned."""
        wanted = self._sought.mark.kind
        planned = float(self._view.camera_T_landmark[2, 3])
        return planned if kind == wanted else float(base_T_camera[2, 3]) - kind.height

    def _is_over(self, seen: _Seen, base_T_camera: Transform) -> bool:
        """Return whether a remembered mark should be in the last picture, which then replaces it."""
        again = any(
            at.distance(last.at[kind]) < MIN_MARK_SPACING_M
            for last in self._last
            for kind, at in seen.at.items()
            if kind in last.at
        )
        return again or any(self._inside(base_T_camera, kind, [at])[0] for kind, at in seen.at.items())

    def _inside(self, base_T_camera: Transform, kind: Kind, places: Sequence[Pose2]) -> BoolArray:
        return wholly_in_view(self._robot.camera.model, base_T_camera, kind, places)

    def _shown(self, kind: Kind, places: Sequence[Pose2]) -> BoolArray:
        inside = [self._inside(camera, kind, places) for camera in self._cameras]
        return np.any(inside, axis=0) if inside else np.zeros(len(places), dtype=bool)


def offsets(rings: int) -> list[tuple[float, float]]:
    """Return the positions of further camera views in search of a landmark.

    Each is x and y relative to the first view, in [m]. They are on a square grid around the first view, the
    nearest first.

    Args:
        rings: number of rings of the grid around the first view.
    """
    steps = [SEARCH_STEP_M * n for n in range(-rings, rings + 1)]
    views = [(x, y) for x in steps for y in steps if (x, y) != (0.0, 0.0)]
    return sorted(views, key=lambda view: (math.hypot(*view), math.atan2(view[1], view[0])))
