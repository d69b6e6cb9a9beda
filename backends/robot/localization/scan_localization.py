"""Localization by scan matching."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np
from typing_extensions import override

from handcart.backends.backend import Backend
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.plain_values import Kinds, attributes, set_attributes
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.localization.localizer import LEAST_INLIERS, ScanLocalizer
from handcart.robotics.navigation.maps.expected_echoes import expected_echoes
from handcart.robotics.navigation.odometry.watched_moment import Belief
from handcart.robotics.navigation.scans.start_search import SURE_FIT
from handcart.robotics.navigation.scans.surface_depth import depth_shifts
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.numerics.covariances import remove_part

from .determination import NO_SHIFT
from .held_base import HeldBase
from .lidar import MIN_ECHOES, Lidar, beams_of
from .localization import Localization
from .lost import Lost, lost_by_stale_lidar
from .pose_covariance import SCAN_REPEATABILITY, repeatability_of

CLEAR_ECHOES_RATIO = 2.0  # of the fewest echoes that show a pose, which the map must exceed to expect them
MIN_SHARE_FOUND = 0.85  # of the share explained before, from which a scan shows where a base is that was held


class ScanLocalization(Localization):
    """Localization by wheels, corrected by matching lidar scans with the map."""

    STATE: ClassVar[Kinds] = {**Localization.STATE, "_map_error_then": FloatArray}

    def __init__(self, backend: Backend, matching: ScanLocalizer, lidar: RangeSensor | None) -> None:
        """Begin with a robot at rest, and match a scan at once.

        Args:
            backend: backend of the robot.
            matching: estimator of the pose, with its map.
            lidar: lidar with interpreted scans; must not be None.
        """
        super().__init__(backend, matching, lidar)
        self._matching, self._map_error_then = matching, np.zeros((3, 3))
        self.map_field = matching.field
        assert self._range_sensor is not None, "scans come from a range sensor"
        matching.correct(self._range_sensor.scan().points())
        if isinstance(lidar, Lidar):
            matching.expects_echoes = lambda pose: self._expects_echoes(lidar, pose)
            matching.check_start(beams_of(lidar))
            self.held_base = HeldBase(matching, lidar, backend.period)
        self._share_before = 0.0  # of the scan that the map explained while nothing denied the wheels
        self.set_origin()

    @property
    @override
    def repeatability(self) -> FloatArray:
        return repeatability_of(self.covariance, self._matching.map_error)

    @property
    @override
    def map_shift(self) -> FloatArray:
        if self._range_sensor is None or not self._matching.sure:
            return NO_SHIFT
        return depth_shifts(self._matching.field, self._range_sensor.scan().points(), self.pose)

    @property
    def displacement(self) -> Belief:
        """Motion of the base since `set_origin`, in the base frame at that time.

        Mean (3,) and covariance (3, 3) of the motion ahead and to the left, in [m], and of the turn to the
        left, in [rad]. The covariance does not contain the map's error, which the poses at start and end of
        the motion share.
        """
        mean, spread = self._matching.odometry.displacement
        shared = self._map_error_then + self._matching.map_error
        turned = _turned(self._matching.odometry.origin.theta)
        return Belief(mean, remove_part(spread, turned @ shared @ turned.T) + 2.0 * SCAN_REPEATABILITY)

    @override
    def set_origin(self) -> None:
        super().set_origin()
        self._map_error_then = self._matching.map_error

    @property
    @override
    def source(self) -> str:
        return "RangeSensor"

    @property
    @override
    def dead_reckoned(self) -> bool:
        return False

    @property
    @override
    def lost(self) -> Lost | None:
        if self.lifted is not None:
            return self.lifted
        if not self._matching.lost:
            return lost_by_stale_lidar(self.stale_s) or self.held_base.lost
        share = "share of the scan that the map explains"
        silence = self._range_sensor.silence if isinstance(self._range_sensor, Lidar) else ""
        if silence:
            echoes = float(len(self._range_sensor.scan().points())) if self._range_sensor else 0.0
            return Lost(silence, "RangeSensor", "beams of a scan that return", echoes, float(MIN_ECHOES))
        if self._matching.misplaced:
            why = "it isn't where it should start: its scan fits other places of the map better"
            return Lost(why, "RangeSensor", share, self.explained, SURE_FIT)
        return Lost("its scans fit the map nowhere near", "RangeSensor", share, self.explained, LEAST_INLIERS)

    @property
    @override
    def explained(self) -> float:
        match = self._matching.last_match
        return super().explained if match is None else match.inliers

    @property
    @override
    def _is_found(self) -> bool:
        if not self.held_base.searches:
            self._share_before = self.explained
            return True
        return self._matching.sure and self.explained >= MIN_SHARE_FOUND * self._share_before

    def _expects_echoes(self, lidar: Lidar, pose: Pose2) -> bool:
        """Return whether a lidar at map_T_base gets clearly more than `MIN_ECHOES` returns by the map."""
        scan, grid = lidar.scan(), self._matching.field.map
        if lidar.blockage:
            return True
        beams = expected_echoes(grid, pose.compose(scan.base_T_sensor), scan.angles, lidar.spec.reach_m)
        return int(beams.met.sum()) > CLEAR_ECHOES_RATIO * MIN_ECHOES

    def _parts(self) -> dict[str, tuple[object, Kinds]]:
        slip, way, layer = self._matching.slip, self._matching.way, self._matching.unmapped.layer
        parts = super()._parts()
        parts |= {"slip": (slip, slip.STATE), "way": (way, way.STATE)}
        return {**parts, "keyframes": (layer, layer.STATE)}

    @override
    def set_state(self, state: object) -> None:
        layer = self._matching.unmapped.layer
        layer.clear()
        if isinstance(state, dict) and "keyframes" not in state:  # older checkpoints have none
            state = {**state, "keyframes": attributes(layer, layer.STATE)}
        super().set_state(state)
        assert isinstance(state, dict)
        layer = self._matching.unmapped.layer  # setting the map began another one
        set_attributes(layer, layer.STATE, state["keyframes"])


def _turned(heading: float) -> FloatArray:
    """Return the rotation (3, 3) of x, y and heading from the map to the frame of a base with a heading in
    [rad].
    """
    cos, sin = math.cos(heading), math.sin(heading)
    return np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
