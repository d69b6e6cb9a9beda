"""Tables and figures of a map that was built from a log: loop closures, uncertainty."""

from __future__ import annotations

import math

import numpy as np

from handcart.robotics.navigation.mapping.map_building import BuiltMap
from handcart.robotics.navigation.mapping.odometry_agreement import (
    OdometryAgreement,
    disagreement_in_words,
    odometry_agreement,
)
from handcart.robotics.navigation.mapping.scan_log import ScanLog

LOOPS_FILE = "loops.csv"
LOOP_COLUMNS = "first_time_s,second_time_s,x_m,y_m,heading_rad,inliers,residual_m,chi2"


def loops_csv(log: ScanLog, built: BuiltMap) -> str:
    """Return the accepted loop closures as CSV, one row each.

    The columns are two times in [s], the pose between them, x, y in [m] and heading in [rad], the share of
    inliers, the residual of the match in [m], and chi².
    """
    lines = [LOOP_COLUMNS]
    for loop, chi2 in zip(built.accepted, built.chi2, strict=True):
        assert loop.match is not None
        times = (log.times[built.rows[number]] for number in (loop.first, loop.second))
        cells = [*(f"{time:.3f}" for time in times), *(f"{value:.4f}" for value in loop.match.pose)]
        lines.append(
            ",".join([*cells, f"{loop.match.inliers:.3f}", f"{loop.match.sigma:.4f}", f"{chi2:.3f}"])
        )
    return "\n".join(lines) + "\n"


def position_sigmas(built: BuiltMap) -> np.ndarray:
    """Return the standard deviation (n,) of each robot position on the mapping drive, in [m].

    It is taken in the direction in which the position is most uncertain.
    """
    worst = np.linalg.eigvalsh(built.covariances[:, :2, :2])[:, -1]
    sigmas: np.ndarray = np.sqrt(np.maximum(worst, 0.0))
    return sigmas


def agreement_of(log: ScanLog, built: BuiltMap) -> OdometryAgreement:
    """Return how well the motions between the map's keyframes agree with the odometry of its log."""
    return odometry_agreement(log.odometry[built.rows], built.poses)


def figures(log: ScanLog, built: BuiltMap) -> dict[str, object]:
    """Return figures about a built map for `summary.json`: scans, loop closures, uncertainty and size."""
    sigmas, rows, agreement = position_sigmas(built), built.counts.hits.shape, agreement_of(log, built)
    residuals = [loop.match.sigma for loop in built.accepted if loop.match is not None]
    inliers = [loop.match.inliers for loop in built.accepted if loop.match is not None]
    return {
        "scans": len(log.times),
        "duration_s": round(float(log.times[-1] - log.times[0]), 3),
        "distance_m": round(log.distance, 2),
        "keyframes": len(built.rows),
        "unmatched_motions": built.blind,
        "loop_closures": {
            "accepted": len(built.accepted),
            "rejected": dict(sorted(built.rejected.items())),
            "residual_m": _median(residuals),
            "inliers": _median(inliers),
            "chi2": _median(built.chi2.tolist()),
            "shift_m": round(built.shift, 3),
        },
        "position_sigma_m": {"median": _median(sigmas.tolist()), "max": round(float(sigmas.max()), 4)},
        "size_m": [round(count * built.counts.resolution, 3) for count in rows[::-1]],
        "resolution_m": built.counts.resolution,
        "odometry": {
            "turn_ratio": _rounded(agreement.turn_ratio),
            "travel_ratio": _rounded(agreement.travel_ratio),
            "off_deg": _rounded(agreement.off_rad and math.degrees(agreement.off_rad)),
        },
        "notes": [*log.notes, *disagreement_in_words(agreement)],
    }


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 4)


def _median(values: list[float]) -> float | None:
    return round(float(np.median(values)), 4) if values and math.isfinite(sum(values)) else None
