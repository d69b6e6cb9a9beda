"""Map that grows by keyframes while a robot drives: chain, loop closures and pose graph of `build_map`."""

from __future__ import annotations

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.mapping.keyframe_graph import KeyframeGraph
from handcart.robotics.navigation.mapping.line_matching import LineMatch
from handcart.robotics.navigation.mapping.map_building import BuiltMap, built_of
from handcart.robotics.navigation.mapping.pose_graph import covariances
from handcart.robotics.navigation.mapping.ray_counts import count_rays
from handcart.robotics.navigation.mapping.scan_chain import (
    MIN_INLIERS,
    RECENT_KEYFRAMES,
    matched_motion,
    odometry_information,
    submap,
)
from handcart.robotics.navigation.mapping.scan_log import Keyframe
from handcart.robotics.navigation.mapping.scan_surface import Surface
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.scans.likelihood_field import LikelihoodField
from handcart.robotics.navigation.scans.scan_matching import match_scan
from handcart.robotics.numerics.arrays import FloatArray

from .merged_map import merge_maps

SEARCH_KEYFRAMES = 6
"""New keyframes after which loops are searched."""
MIN_KNOWN_SHARE = 0.7
"""Share of a scan that a given map must explain to measure a keyframe's pose."""
START_KEYFRAMES = 4
"""First keyframes, by which the pose at the start is found again."""


class GrowingMap:
    """Map that is built while the robot drives, as a graph of keyframes (lidar scans with their poses).

    The frame of the map is that of the first pose, or of a given map that is completed.
    """

    def __init__(
        self, first: Keyframe, pose: Pose2, known: GridMap | None = None, sigma: float = 0.01
    ) -> None:
        """Begin with a keyframe.

        Args:
            first: scan at the start.
            pose: map_T_base at that scan.
            known: given map, to be completed; None without one.
            sigma: noise of a range, in [m].
        """
        self.graph = KeyframeGraph([first], [pose], [])
        self.blind = 0
        """Number of motions that only the odometry measured."""
        self._chained, self._known, self._sigma = [pose], known, sigma
        self._field = None if known is None or not known.occupied.any() else LikelihoodField(known)
        self._searched = 0
        self._found: tuple[Pose2, Pose2] | None = None

    @property
    def last(self) -> Keyframe:
        """Keyframe (scan with the odometry's pose) that was added last."""
        return self.graph.frames[-1]

    @property
    def poses(self) -> list[Pose2]:
        """Poses map_T_base of all keyframes, in the order in which they were added."""
        return self.graph.poses

    def pose_of(self, odometry: Pose2) -> Pose2:
        """Return map_T_base: the pose of the latest keyframe, or the pose set by `carry_on_from`, moved by
        the odometry since then.

        Args:
            odometry: odom_T_base at the time for which map_T_base is wanted.
        """
        last, pose = (self.last.odometry, self.poses[-1]) if self._found is None else self._found
        return pose.compose(odometry.relative_to(last))

    def carry_on_from(self, odometry: Pose2, displacement: Pose2) -> None:
        """Set a measured pose of the base, from which later poses are computed by odometry.

        The method `pose_of` uses this pose until the next keyframe is added.

        Args:
            odometry: odom_T_base when the pose was measured.
            displacement: measured pose of the base in the frame of the first keyframe.
        """
        self._found = odometry, self.poses[0].compose(displacement)

    def add(self, frame: Keyframe) -> LineMatch:
        """Match a keyframe with those before it, and add it.

        Returns:
            The match, whose pose is that of the new keyframe in the frame of the keyframe before.
        """
        graph, self._found = self.graph, None
        moved = frame.odometry.relative_to(self.last.odometry)
        frames, poses = graph.frames[-RECENT_KEYFRAMES:], graph.poses[-RECENT_KEYFRAMES:]
        match = matched_motion(submap(frames, poses, poses[-1]), frame.surface, moved)
        self.blind += match.inliers < MIN_INLIERS
        number = len(graph.frames)
        self._chained.append(self._chained[-1].compose(match.pose))
        pose = Pose2(*map(float, poses[-1].compose(match.pose)))
        graph.append(frame, pose, match)
        self._measure(number)
        return match

    def _measure(self, number: int) -> None:
        """Add the pose of a keyframe on the given map, where that explains its scan."""
        if self._field is None:
            return
        frame, pose = self.graph.frames[number], self.poses[number]
        moved = pose.relative_to(self.poses[number - 1])
        prior = np.asarray(np.linalg.inv(odometry_information(moved)), dtype=np.float64)
        match = match_scan(self._field, frame.hits, pose, prior, self._sigma)
        if match.inliers >= MIN_KNOWN_SHARE:
            information = np.asarray(np.linalg.inv(match.covariance), dtype=np.float64)
            self.graph.measure(number, match.pose, information)

    @property
    def is_search_due(self) -> bool:
        """True if `SEARCH_KEYFRAMES` keyframes or more were added since the last search for loop closures."""
        return len(self.poses) - self._searched >= SEARCH_KEYFRAMES

    def search(self) -> None:
        """Search for loop closures between the latest and earlier keyframes; correct all poses if one is
        found.
        """
        since, self._searched = max(0, self._searched - SEARCH_KEYFRAMES), len(self.poses)
        if self._field is not None:
            self.graph.optimize()
        self.graph.search(since=since)

    def finish(self) -> None:
        """Search for all loop closures, match each keyframe with all that see the same place, and correct all
        poses.
        """
        self.graph.search()
        self.graph.refine()

    def covariance(self) -> FloatArray:
        """Return the covariance (3, 3) of the latest pose relative to the first.

        Rows are x, y and heading along the axes of the map, in [m, m, rad].
        """
        return np.asarray(covariances(np.array(self.poses), self.graph.edges)[-1])

    def grid(self, resolution: float) -> GridMap:
        """Return the map drawn from all keyframes; a map given at the start fills the cells that stay
        unknown.

        Args:
            resolution: size of a cell, in [m].
        """
        drawn = count_rays(self.graph.frames, self.poses, resolution).grid
        return drawn if self._known is None else merge_maps(drawn, self._known)

    @property
    def start_surface(self) -> Surface:
        """Surfaces of the surroundings in the scans of the first keyframes, in the base frame of the first
        keyframe.
        """
        frames, poses = self.graph.frames[:START_KEYFRAMES], self.poses[:START_KEYFRAMES]
        return submap(frames, poses, poses[0])

    def built(self, resolution: float) -> BuiltMap:
        """Return the map drawn with cells of size `resolution`, in [m], with its trajectory and loop
        closures.
        """
        rows = [frame.row for frame in self.graph.frames]
        return built_of(self.graph, rows, self.blind, self._chained, resolution)
