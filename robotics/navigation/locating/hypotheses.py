"""Poses that explain all scans so far, and the test whether one of them is left.

A hypothesis is refuted when the scans are `REFUTED_ODDS` times as likely from the best one. Scans from places
close to each other see the same things, also those that are on no map, so a scan counts by how far it was
taken from the ones before, and by its share of directions in which they did not look.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.scans.likelihood_field import LikelihoodField
from handcart.robotics.navigation.scans.start_search import ScanBeams
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IntArray

from .beam_evidence import explain, matching_noise
from .global_search import KEPT_LOG, PLAIN_LOG, refine_poses, same_place, search_map

REFUTED_ODDS = 1e6
"""Odds of the best hypothesis against another one, from which the other one is refuted."""
REFUTED_LOG = math.log(REFUTED_ODDS)
MIN_EXPLAINED = 0.7
"""Share of the beams of all scans that the map has to explain from the best hypothesis."""
NEW_SCAN_M = 1.0  # from all earlier scans, where a scan counts fully
SAME_BEAM_RAD = math.radians(3.0)  # between beams of two scans that look in one direction
ODOMETRY_M, ODOMETRY_RATIO, ODOMETRY_RAD = 0.05, 0.03, 0.02  # sigma of a motion, of its length, of its turn
MAX_ODOMETRY_LOG = 12.0  # that a motion which does not fit costs at most
MAX_HYPOTHESES = 120


class Look(NamedTuple):
    """A scan taken at rest, with the base's pose at that time and the weight of the scan."""

    beams: ScanBeams
    pose: Pose2
    """local_T_base, by odometry and matching with what was seen before."""
    weight: float
    """Weight of the scan, 0 to 1; 1 at `NEW_SCAN_M` or more from all earlier ones, or where none of them
    looked.
    """


class Hypotheses:
    """Hypotheses for the unknown pose of a base on a map, the best first, from several scans taken at
    rest.
    """

    def __init__(self, field: LikelihoodField, sigma: float) -> None:
        """Start without a scan, on the map of a field; `sigma` of a range, in [m]."""
        self._field, self._noise = field, matching_noise(field, sigma)
        self.looks: list[Look] = []
        """Scans so far."""
        self.poses: FloatArray = np.empty((0, 3))
        """(n, 3) map_T_base at the last scan, in [m, m, rad]."""
        self.log_likelihoods: FloatArray = np.empty(0)
        """(n,) of all scans."""
        self.explained: FloatArray = np.empty(0)
        """(n,) share of the beams of all scans that the map explains."""

    def take(self, beams: ScanBeams, pose: Pose2) -> None:
        """Update the hypotheses about the robot's pose by a scan at rest, and search the map for new ones
        after the first two scans and whenever no hypothesis is likely.

        Args:
            beams: beams of the scan.
            pose: local_T_base at the scan, by odometry and matching with earlier scans; the frame is that of
                the first scan.
        """
        look = Look(beams, pose, self._new_share(beams, pose))
        before = self.looks[-1] if self.looks else None
        poses, likely, explained = self.poses, self.log_likelihoods, self.explained
        if before is not None and len(poses):
            poses, cost, share = self._moved(poses, before, look)
            likely, explained = likely + cost, explained + look.weight * share
        self.looks.append(look)
        if self._needs_search(likely):
            new = search_map(self._field, beams, self._noise).poses
            for pose_there in poses:
                new = new[~same_place(new, pose_there)]
            found, total, shares = self._traced_back(new)
            poses = np.vstack([poses, found])
            likely, explained = np.concatenate([likely, total]), np.concatenate([explained, shares])
        self._keep(poses, likely, explained)

    @property
    def alive(self) -> IntArray:
        """Indices (k,) of the hypotheses whose log-likelihood is within `REFUTED_LOG` of the best one's."""
        if not len(self.log_likelihoods):
            return np.empty(0, dtype=np.int64)
        return np.flatnonzero(self.log_likelihoods >= self.log_likelihoods[0] - REFUTED_LOG)

    @property
    def share(self) -> float:
        """Mean share of the scans' beams that agree with the map at the best hypothesis, from 0 to 1."""
        weight = sum(look.weight for look in self.looks)
        return float(self.explained[0]) / weight if len(self.explained) and weight > 0.0 else 0.0

    @property
    def margin(self) -> float:
        """Logarithm of the odds of the best hypothesis against the second; infinite if there is no second."""
        likely = self.log_likelihoods
        return float(likely[0] - likely[1]) if len(likely) > 1 else math.inf

    @property
    def is_explained(self) -> bool:
        """True if at least `MIN_EXPLAINED` of the scans' beams agree with the map at the best hypothesis."""
        return self.share >= MIN_EXPLAINED

    @property
    def is_unique(self) -> bool:
        """True if only one hypothesis of the base's pose is still likely, and the scans agree with the map
        there.
        """
        return self.is_explained and len(self.alive) == 1

    def _new_share(self, beams: ScanBeams, pose: Pose2) -> float:
        """Return the share of a scan that is new, 0 to 1: 1 in directions in which no earlier scan looked,
        otherwise less the nearer the earlier scans were taken.
        """
        looking = beams.angles[~np.isnan(beams.ranges)]
        new = np.ones(len(looking))
        for look in self.looks:
            angles = look.beams.angles[~np.isnan(look.beams.ranges)] + (look.pose.theta - pose.theta)
            covered = _near_any(looking, angles)
            new[covered] = np.minimum(new[covered], pose.distance(look.pose) / NEW_SCAN_M)
        return float(new.mean()) if len(new) else 0.0

    def _needs_search(self, likely: FloatArray) -> bool:
        count = sum(look.weight for look in self.looks)
        return len(self.looks) <= 2 or not len(likely) or float(likely.max()) < PLAIN_LOG * count

    def _moved(
        self, poses: FloatArray, before: Look, after: Look
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return map_T_base (n, 3) after the motion between two scans, the log-likelihoods (n,) of motion
        and scan, and the shares (n,) of the scan that the map explains.
        """
        step = after.pose.relative_to(before.pose)
        predicted = np.array([Pose2(*pose).compose(step) for pose in poses.tolist()]).reshape(-1, 3)
        points = after.beams.points
        fitted = refine_poses(self._field, points, predicted, self._noise, ())
        fit = explain(self._field, after.beams, fitted, self._noise)
        off = fitted - predicted
        sigma = ODOMETRY_M + ODOMETRY_RATIO * math.hypot(step.x, step.y)
        turn_sigma = ODOMETRY_RAD + ODOMETRY_RATIO * abs(step.theta)
        turned = np.array([wrap(float(turn)) for turn in off[:, 2]])
        squares = (off[:, 0] ** 2 + off[:, 1] ** 2) / sigma**2 + (turned / turn_sigma) ** 2
        cost = -np.minimum(0.5 * squares, MAX_ODOMETRY_LOG)
        return fitted, cost + after.weight * fit.log_likelihood, fit.explained

    def _traced_back(self, poses: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return map_T_base (n, 3) at the last scan, the log-likelihoods (n,) of all scans, and the sums
        (n,) of the shares explained.
        """
        last = self.looks[-1]
        if not len(poses):
            return np.empty((0, 3)), np.empty(0), np.empty(0)
        fit = explain(self._field, last.beams, poses, self._noise)
        total, shares = last.weight * fit.log_likelihood, last.weight * fit.explained
        there, later = poses, last
        for look in reversed(self.looks[:-1]):
            there, cost, share = self._moved(there, later, look)
            total, shares, later = total + cost, shares + look.weight * share, look
        return poses, total, shares

    def _keep(self, poses: FloatArray, likely: FloatArray, explained: FloatArray) -> None:
        """Keep the best hypotheses, from different places each."""
        kept: list[int] = []
        left = np.argsort(-likely, kind="stable")
        best = float(likely.max()) if len(likely) else 0.0
        while len(left) and len(kept) < MAX_HYPOTHESES and likely[left[0]] >= best - KEPT_LOG:
            kept.append(int(left[0]))
            left = left[~same_place(poses[left], poses[left[0]])]
        self.poses, self.log_likelihoods = poses[kept].reshape(-1, 3), likely[kept]
        self.explained = explained[kept]


def _near_any(angles: FloatArray, others: FloatArray) -> BoolArray:
    """Return a mask (n,) of the angles (n,) with another one (m,) at most `SAME_BEAM_RAD` away, in [rad]."""
    if not len(others):
        return np.zeros(len(angles), dtype=np.bool_)
    turns = np.sort(others % (2.0 * math.pi))
    turns = np.concatenate([turns[-1:] - 2.0 * math.pi, turns, turns[:1] + 2.0 * math.pi])
    turned = angles % (2.0 * math.pi)
    after = np.clip(np.searchsorted(turns, turned), 1, len(turns) - 1)
    away = np.minimum(turned - turns[after - 1], turns[after] - turned)
    return np.asarray(away <= SAME_BEAM_RAD)
