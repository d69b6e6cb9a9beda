"""`handcart localize` on ROS bags, written by another library."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.field.field_course import straight_course
from benchmarks.field.field_drive import PERIOD_S, FieldTimes
from benchmarks.field.field_log import FieldLog, record_course
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_NOISE

pytest.importorskip("rosbags", reason="bags are read by the extra `bags`")

LATITUDE, LONGITUDE, METRES = 47.0, 8.0, 111_170.0


def write_bag(folder: Path, log: FieldLog, storage: str, topics: tuple[str, ...]) -> Path:
    """A bag of rosbag2 with what a robot's drivers publish."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    kinds = store.types
    time, header, vector = (
        kinds[f"{name}"]
        for name in ("builtin_interfaces/msg/Time", "std_msgs/msg/Header", "geometry_msgs/msg/Vector3")
    )
    point, turned = kinds["geometry_msgs/msg/Point"], kinds["geometry_msgs/msg/Quaternion"]
    fixes = dict(zip(log.fix_rows.tolist(), log.fixes, strict=True))
    nothing, upright = np.zeros(36), turned(x=0.0, y=0.0, z=0.0, w=1.0)

    def imu(row: int, head: Any) -> Any:
        rates, felt = log.rates[row], log.accelerations[row]
        return kinds["sensor_msgs/msg/Imu"](
            header=head,
            orientation=upright,
            orientation_covariance=np.zeros(9),
            angular_velocity=vector(*rates.tolist()),
            angular_velocity_covariance=np.zeros(9),
            linear_acceleration=vector(*felt.tolist()),
            linear_acceleration_covariance=np.zeros(9),
        )

    def odometry(row: int, head: Any) -> Any:
        x, y, heading = log.drive.poses[row].tolist()
        pose = kinds["geometry_msgs/msg/Pose"](
            point(x, y, 0.0), turned(0.0, 0.0, math.sin(heading / 2), math.cos(heading / 2))
        )
        speed = float(log.wheels[row].mean()) / PERIOD_S
        twist = kinds["geometry_msgs/msg/Twist"](vector(speed, 0.0, 0.0), vector(0.0, 0.0, 0.0))
        return kinds["nav_msgs/msg/Odometry"](
            head,
            "base_link",
            kinds["geometry_msgs/msg/PoseWithCovariance"](pose, nothing),
            kinds["geometry_msgs/msg/TwistWithCovariance"](twist, nothing),
        )

    def fix(row: int, head: Any) -> Any | None:
        if row not in fixes:
            return None
        x, y = fixes[row]
        lon = LONGITUDE + x / (METRES * math.cos(math.radians(LATITUDE)))
        status = kinds["sensor_msgs/msg/NavSatStatus"](status=0, service=1)
        covariance = np.diag([1.0, 1.0, 4.0]).ravel()
        return kinds["sensor_msgs/msg/NavSatFix"](
            head, status, LATITUDE + y / METRES, lon, 400.0, covariance, 2
        )

    messages = {"/imu": imu, "/odom": odometry, "/fix": fix, "/truth": odometry}
    with Writer(folder, version=9, storage_plugin=StoragePlugin[storage]) as writer:
        for topic in topics:
            make = messages[topic]
            name = next(
                kind
                for kind, made in (("Imu", imu), ("Odometry", odometry), ("NavSatFix", fix))
                if make is made
            )
            package = "nav_msgs" if name == "Odometry" else "sensor_msgs"
            kind = f"{package}/msg/{name}"
            connection = writer.add_connection(topic, kind, typestore=store)
            for row in range(len(log.rates)):
                stamp: Any = time(
                    sec=1000 + int(PERIOD_S * row), nanosec=round(1e9 * (PERIOD_S * row % 1.0)) % 10**9
                )
                message = make(row, header(stamp, "base_link"))
                if message is not None:
                    at = 10**9 * stamp.sec + stamp.nanosec
                    writer.write(connection, at, store.serialize_cdr(message, kind))
    return folder


@pytest.fixture(scope="module")
def drive() -> FieldLog:
    return record_course(straight_course(2), REFERENCE_NOISE, 1, FieldTimes(wait=15.0, dwell=5.0))


@pytest.mark.slow
@pytest.mark.parametrize("storage", ["SQLITE3", "MCAP"])
def test_a_bag_is_played(tmp_path: Path, drive: FieldLog, storage: str, handcart: Callable[..., Any]) -> None:
    bag = write_bag(tmp_path / "bag", drive, storage, ("/odom", "/imu", "/fix", "/truth"))
    said = handcart("localize", bag, "--reference", "/truth", "--json")
    assert said.status == 0, said.err
    found = json.loads(said.out)
    assert found["fixes"] == len(drive.fixes)
    assert found["error_m_rms"] < 2.5  # about the first fix, which is off by itself
    inside = next(path for path in bag.iterdir() if path.suffix in (".db3", ".mcap"))
    assert json.loads(handcart("localize", inside, "--json").out)["fixes"] == len(drive.fixes)


@pytest.mark.slow
def test_a_sideways_imu_is_never_played_silently(
    tmp_path: Path, drive: FieldLog, handcart: Callable[..., Any]
) -> None:
    sideways = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])  # imu_R_base
    turned = drive._replace(rates=drive.rates @ sideways.T, accelerations=drive.accelerations @ sideways.T)
    bag = write_bag(tmp_path / "bag", turned, "SQLITE3", ("/odom", "/imu", "/fix", "/truth"))
    said = handcart("localize", bag, "--reference", "/truth")
    assert said.status == 2
    assert "gravity is along its +y axis" in said.err
    assert "--imu-axes z,x,y (forward, left, up)" in said.err
    for axes in ("auto", "z,x,y"):
        found = json.loads(
            handcart("localize", bag, "--reference", "/truth", "--imu-axes", axes, "--json").out
        )
        assert found["error_m_rms"] < 2.5
    said = handcart("localize", bag, "--imu-axes", "x,x,y")
    assert said.status == 2
    assert "'x,x,y' is not a frame" in said.err


def test_what_a_bag_lacks_is_told_at_once(
    tmp_path: Path, drive: FieldLog, handcart: Callable[..., Any]
) -> None:
    bag = write_bag(tmp_path / "bag", drive, "SQLITE3", ("/fix",))
    said = handcart("localize", bag, "--reference", "/truth")
    assert said.status == 2
    for wrong in (
        "no sensor_msgs/msg/Imu in it",
        "no nav_msgs/msg/Odometry in it",
        "no poses on the topic '/truth'",
    ):
        assert wrong in said.err


def test_a_bag_without_the_library_names_the_extra(
    tmp_path: Path, handcart: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("handcart.files.extras.is_there", lambda module: module != "rosbags")
    said = handcart("localize", tmp_path)
    assert said.status == 2
    assert "pip install 'handcart[bags]'" in said.err
