"""The files of a map: the cells in ROS format, the trajectory and the loop closures as tables."""

from __future__ import annotations

import math
from pathlib import Path

import cv2
import numpy as np

from handcart.files.whole_file import write_whole
from handcart.robotics.navigation.mapping.map_building import BuiltMap
from handcart.robotics.navigation.mapping.scan_log import ScanLog
from handcart.robotics.navigation.maps.grid_map import UNKNOWN_GREY, GridMap

MAP_FILE, PICTURE_FILE = "map.yaml", "map.pgm"
TRAJECTORY_FILE, LOOPS_FILE = "trajectory.csv", "loops.csv"
OCCUPIED_GREY, FREE_GREY = 0, 254
TRAJECTORY_COLUMNS = "time_s,x_m,y_m,heading_rad,xx_m2,xy_m2,yy_m2,xh_m_rad,yh_m_rad,hh_rad2"
LOOP_COLUMNS = "first_time_s,second_time_s,x_m,y_m,heading_rad,inliers,residual_m,chi2"


def write_grid(path: Path, grid: GridMap) -> None:
    """Write a map as a YAML file and, beside it, a PGM picture of the same name.

    Raises:
        OSError: a file cannot be written.
    """
    grey = np.where(grid.occupied, OCCUPIED_GREY, np.where(grid.unknown, UNKNOWN_GREY, FREE_GREY))
    _, pgm = cv2.imencode(".pgm", grey.astype(np.uint8)[::-1])
    picture = path.with_suffix(".pgm")
    write_whole(picture, pgm.tobytes())
    write_whole(
        path,
        f"image: {picture.name}\nresolution: {grid.resolution:.6g}\n"
        f"origin: [{grid.origin_x:.6f}, {grid.origin_y:.6f}, 0.0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n",
    )


def trajectory_csv(log: ScanLog, built: BuiltMap) -> str:
    """Return the pose of each keyframe with its covariance, one row each."""
    lines = [TRAJECTORY_COLUMNS]
    for row, pose, spread in zip(built.rows, built.poses, built.covariances, strict=True):
        upper = spread[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]
        cells = [f"{log.times[row]:.3f}", *(f"{value:.4f}" for value in pose)]
        lines.append(",".join([*cells, *(f"{value:.6g}" for value in upper)]))
    return "\n".join(lines) + "\n"


def loops_csv(log: ScanLog, built: BuiltMap) -> str:
    """Return the accepted loop closures, one row each: two times, the pose between them, how good it is."""
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
    """Return the standard deviation (n,) of each position in its worst direction, in [m]."""
    worst = np.linalg.eigvalsh(built.covariances[:, :2, :2])[:, -1]
    sigmas: np.ndarray = np.sqrt(np.maximum(worst, 0.0))
    return sigmas


def figures(log: ScanLog, built: BuiltMap) -> dict[str, object]:
    """Return the figures of a map, for `summary.json`."""
    sigmas, rows = position_sigmas(built), built.counts.hits.shape
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
        "notes": list(log.notes),
    }


def _median(values: list[float]) -> float | None:
    return round(float(np.median(values)), 4) if values and math.isfinite(sum(values)) else None
