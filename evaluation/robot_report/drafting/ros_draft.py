"""Draft of a robot's file for a robot that describes itself on the air."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ElementTree
from typing import Any

from handcart.backends.ros2.air_check.air_description import AirDescription
from handcart.evaluation.robot_report.outline import Outline
from handcart.robotics.kinematics.urdf_contents import joints_of

from .draft import CAMERA_SECTION, LIDAR_SECTION
from .ros_section import MESSAGE_KINDS, chosen, is_upside_down, ros_section


def with_air(text: str, air: AirDescription, outline: Outline, srdf: str) -> str:
    """Add the data that a running robot publishes to a draft of its file.

    These are measured properties of sensors, the SRDF and its postures, and the ROS topics.

    Args:
        text: draft by the URDF alone.
        air: description that the robot publishes of itself.
        outline: outline of the robot by its URDF.
        srdf: name of the SRDF's file; "" without one.
    """
    text = text.replace("`handcart check` from the URDF alone", "`handcart robot` from the robot's topics", 1)
    scan = air.messages.get(chosen("lidar", air.topics[MESSAGE_KINDS["lidar"]])[0])
    if scan is not None and LIDAR_SECTION.split(", ")[0] in text:
        lines = _lidar(scan, is_upside_down(air, scan.header.frame_id, outline.root) or False).split(", ")
        text = text.replace(LIDAR_SECTION, ", ".join(lines))
        text = text.replace("\n  ".join(LIDAR_SECTION.split(", ")), "\n  ".join(lines))
        text = text.replace("# by its data sheet", "# by a scan; sigma_mm by its data sheet", 1)
    info = _camera_info(air)
    if info is not None and any(info.k):
        text = text.replace(
            f"{CAMERA_SECTION}     # by its data sheet", f"{_camera(info)}     # by its camera_info"
        )
    if srdf:
        text = re.sub(r"(?m)^(urdf: .*)$", rf'\1\nsrdf: "{srdf}"', text, count=1)
        text = re.sub(
            r"(?m)^(    home: .*)$", lambda home: "\n".join([home[1], *_postures(air, outline)]), text
        )
    return text + "\n".join(ros_section(air, outline)) + "\n"


def _lidar(scan: Any, flips: bool) -> str:
    """Return the section of a lidar by a scan; `flips` is True if it is mounted upside down."""
    ends = scan.angle_min, scan.angle_min + scan.angle_increment * (len(scan.ranges) - 1)
    sign = -1.0 if flips else 1.0
    start, end = sorted(sign * math.degrees(angle) for angle in ends)
    step = abs(math.degrees(scan.angle_increment))
    if abs(end - start + step - 360.0) < 0.5 * step:
        start, end = start, start + 360.0
    low = f", range_min_m: {scan.range_min:.3g}" if scan.range_min > 0.0 else ""
    angles = f"start_deg: {start:.5g}, end_deg: {end:.5g}"
    return f"beams: {len(scan.ranges)}, {angles}{low}, reach_m: {scan.range_max:.4g}, sigma_mm: 20"


def _camera_info(air: AirDescription) -> Any:
    """Return the calibration beside the chosen camera's pictures; None without one."""
    image = chosen("camera", air.topics[MESSAGE_KINDS["camera"]])[0]
    return air.messages.get(f"{image.rpartition('/')[0]}/camera_info") if image else None


def _camera(info: Any) -> str:
    lens = dict(zip(("k1", "k2", "p1", "p2", "k3"), info.d, strict=False))
    more = "".join(f", {name}: {value:.6g}" for name, value in lens.items() if value)
    more = more if info.distortion_model in ("", "plumb_bob") else ""
    return f"{{width_px: {info.width}, height_px: {info.height}, focal_px: {info.k[0]:.6g}{more}}}"


def _postures(air: AirDescription, outline: Outline) -> list[str]:
    """Return the postures of the SRDF that name all joints of the arm, as lines."""
    facts = {item.name: item for item in joints_of(air.urdf)}
    lines, used = [], {"home"}
    for state in ElementTree.fromstring(air.srdf).iter("group_state"):
        values = {item.get("name", ""): item.get("value", "0") for item in state.iter("joint")}
        name = re.sub(r"\W", "_", state.get("name", ""))
        if not all(joint in values for joint in outline.arm) or name in used:
            continue
        used.add(name)
        scales = (1e3 if facts[joint].kind == "prismatic" else math.degrees(1.0) for joint in outline.arm)
        numbers = (
            f"{scale * float(values[joint]):.4g}" for joint, scale in zip(outline.arm, scales, strict=True)
        )
        lines.append(f"    {name}: [{', '.join(numbers)}]     # of the SRDF")
    return lines
