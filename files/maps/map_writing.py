"""Files of a map: cells in ROS format, and the trajectory as a table."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from handcart.files.whole_file import write_whole
from handcart.files.yaml.yaml_word import yaml_word
from handcart.robotics.navigation.maps.grid_map import UNKNOWN_GREY, GridMap
from handcart.robotics.numerics.arrays import FloatArray

MAP_FILE, TRAJECTORY_FILE = "map.yaml", "trajectory.csv"
OCCUPIED_GREY, FREE_GREY = 0, 254
TRAJECTORY_COLUMNS = "time_s,x_m,y_m,heading_rad,xx_m2,xy_m2,yy_m2,xh_m_rad,yh_m_rad,hh_rad2"


def write_grid(path: Path, grid: GridMap, picture: str = ".pgm") -> None:
    """Write a map as a YAML file in ROS format and, in the same folder, a picture of the same name.

    Args:
        path: the YAML file.
        grid: the map.
        picture: ending of the picture's name, `.pgm` or `.png`.

    Raises:
        OSError: a file cannot be written.
    """
    grey = np.where(grid.occupied, OCCUPIED_GREY, np.where(grid.unknown, UNKNOWN_GREY, FREE_GREY))
    _, encoded = cv2.imencode(picture, grey.astype(np.uint8)[::-1])
    image = path.with_suffix(picture)
    write_whole(image, encoded.tobytes())
    write_whole(
        path,
        f"image: {yaml_word(image.name)}\nresolution: {grid.resolution:.6g}\n"
        f"origin: [{grid.origin_x:.6f}, {grid.origin_y:.6f}, 0.0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n",
    )


def trajectory_csv(times: FloatArray, poses: FloatArray, covariances: FloatArray) -> str:
    """Return a table in CSV with a row for each keyframe: its time, pose and covariance.

    Args:
        times: (n,) in [s].
        poses: (n, 3) map_T_base: x, y in [m], heading in [rad].
        covariances: (n, 3, 3) of the poses, along the map's axes, in [m, m, rad].
    """
    lines = [TRAJECTORY_COLUMNS]
    for time, pose, spread in zip(times, poses, covariances, strict=True):
        upper = spread[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]
        cells = [f"{time:.3f}", *(f"{value:.4f}" for value in pose)]
        lines.append(",".join([*cells, *(f"{value:.6g}" for value in upper)]))
    return "\n".join(lines) + "\n"
