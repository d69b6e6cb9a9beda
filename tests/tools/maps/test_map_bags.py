"""`handcart map` on ROS bags with tf alone, the lidar upright and upside down."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from .drives import small_drive

pytest.importorskip("rosbags", reason="bags are read by the extra `bags`")


def write_bag(path: Path, storage: str, is_flipped: bool) -> None:
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store, log = get_typestore(Stores.ROS2_HUMBLE), small_drive().log
    kinds: Any = store.types
    quaternion, vector = kinds["geometry_msgs/msg/Quaternion"], kinds["geometry_msgs/msg/Vector3"]

    def header(time: float, frame: str) -> Any:
        stamp = kinds["builtin_interfaces/msg/Time"](int(time) + 1, int((time % 1) * 1e9))
        return kinds["std_msgs/msg/Header"](stamp, frame)

    def link(head: Any, child: str, x: float, y: float, turned: Any) -> Any:
        moved = kinds["geometry_msgs/msg/Transform"](vector(x, y, 0.0), turned)
        return kinds["geometry_msgs/msg/TransformStamped"](head, child, moved)

    mounted = quaternion(1.0, 0.0, 0.0, 0.0) if is_flipped else quaternion(0.0, 0.0, 0.0, 1.0)
    angles = -log.angles[::-1] if is_flipped else log.angles
    with Writer(path, version=9, storage_plugin=StoragePlugin[storage]) as writer:
        names = "sensor_msgs/msg/LaserScan", "tf2_msgs/msg/TFMessage"
        scans, tf = (
            writer.add_connection(t, n, typestore=store) for t, n in zip(("/scan", "/tf"), names, strict=True)
        )
        for row, time in enumerate(log.times.tolist()):
            x, y, heading = log.odometry[row].tolist()
            turned = quaternion(0.0, 0.0, math.sin(heading / 2), math.cos(heading / 2))
            links = [link(header(time, "odom"), "base_link", x, y, turned)]
            links += [] if row else [link(header(time, "base_link"), "laser", 0.0, 0.0, mounted)]
            received = int((time + 1) * 1e9)
            writer.write(tf, received, store.serialize_cdr(kinds[names[1]](links), names[1]))
            ranges = log.ranges[row][::-1] if is_flipped else log.ranges[row]
            limits = float(angles[0]), float(angles[-1]), float(angles[1] - angles[0]), 0.0, 0.2, 0.05, 12.0
            scan = kinds[names[0]](
                header(time, "laser"), *limits, ranges.astype(np.float32), np.zeros(0, "f4")
            )
            writer.write(scans, received, store.serialize_cdr(scan, names[0]))


@pytest.mark.slow
@pytest.mark.parametrize(("storage", "is_flipped"), [("MCAP", False), ("SQLITE3", True)])
def test_bag_without_odometry_topic_is_mapped_by_tf(
    tmp_path: Path, handcart: Callable[..., Any], storage: str, is_flipped: bool
) -> None:
    write_bag(tmp_path / "bag", storage, is_flipped)
    said = handcart("map", tmp_path / "bag", "-o", tmp_path / "map", "--json")
    found = json.loads(said.out)
    assert found["unmatched_motions"] == 0
    assert found["loop_closures"]["accepted"] > 30
    assert any("upside down" in note for note in found["notes"]) is is_flipped
