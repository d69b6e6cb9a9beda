"""What is wrong between a robot's file, its section `can`, and the files of its drives."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from handcart.backends.description.can_spec import VIRTUAL_INTERFACE
from handcart.backends.description.ground_spec import OUTDOOR_LOCALIZERS
from handcart.files.suggest import suggest

from .cyclic_frames import bus_load

if TYPE_CHECKING:
    from handcart.backends.description.can_spec import AxisSpec, CanSpec, JointDriveSpec
    from handcart.backends.description.robot_file import RobotFile
    from handcart.files.errors import Finding
    from handcart.files.yaml.yaml_document import Document

Place = tuple[str | int, ...]
_CYCLIC = ("csp", "csv")


def can_findings(robot: RobotFile, document: Document) -> list[Finding]:
    """Return the faults of a robot's section `can`, each at its place in the robot's file or an EDS file."""
    spec = robot.can
    if spec is None:
        return []
    own = (
        *(_interface(spec), _load(robot, spec), _nodes(spec), _held(spec), _gyros(robot, spec)),
        *(_counts(robot, spec), _periods(robot, spec), _files(robot, spec)),
    )
    found = [document.finding(("can", *place), words) for item in own for place, words in item]
    found += _eds_findings(robot, spec, document)
    return found or _wrap_findings(robot, spec, document)


def _interface(spec: CanSpec) -> Iterator[tuple[Place, str]]:
    if spec.interface == VIRTUAL_INTERFACE:
        return
    from can.interfaces import VALID_INTERFACES

    if spec.interface not in VALID_INTERFACES:
        allowed = suggest(spec.interface, VALID_INTERFACES)
        yield ("interface",), f"unknown interface {spec.interface!r}{allowed}"


def _gyros(robot: RobotFile, spec: CanSpec) -> Iterator[tuple[Place, str]]:
    """Yield a finding if the localizer asks the gyros, and no IMU is connected to the real robot."""
    if (
        robot.localizer in OUTDOOR_LOCALIZERS
        and spec.sensors.imu is None
        and spec.interface != VIRTUAL_INTERFACE
    ):
        words = f"`localizer: {robot.localizer}` asks the gyros, and no IMU is connected"
        yield (
            ("sensors",),
            f"{words}; needed: the key `imu` of `can.sensors`, or the localizer scan or odometry",
        )


def _held(spec: CanSpec) -> Iterator[tuple[Place, str]]:
    """Yield the axes whose load would fall at a stop: place in the section `can`, and the finding."""
    for place, axis in placed_axes(spec):
        if axis.gravity and not axis.brake and axis.stop != "hold":
            words = f"an axis under gravity without a brake would fall with stop: {axis.stop}"
            yield place, f"{words}; allowed: stop: hold, or brake: true, or gravity: false"
        elif axis.gravity and not axis.brake and "quick_stop_option" in axis.without:
            words = "an axis under gravity without a brake may fall at a stop without: [quick_stop_option]"
            yield place, f"{words}; allowed: brake: true, or gravity: false"


def _load(robot: RobotFile, spec: CanSpec) -> Iterator[tuple[Place, str]]:
    """Yield a finding if the bus cannot carry its cyclic frames."""
    load = bus_load(spec, robot.period_s)
    if load.too_much:
        words = (
            f"cyclic frames take {load.share:.0%} of the bus at this bit rate and {robot.period_s} s a period"
        )
        yield ("bitrate_kbit_s",), f"{words}; allowed: at most {load.MAX_CYCLIC_LOAD:.0%}"


def _eds_findings(robot: RobotFile, spec: CanSpec, document: Document) -> list[Finding]:
    """Return the faults in the EDS files of a robot's drives, and needed features that the drives lack."""
    named = [
        (place, axis, robot.folder / axis.eds) for place, axis in placed_axes(spec) if axis.eds is not None
    ]
    there = [item for item in named if item[2].is_file()]
    if not there:
        return []
    from .eds_needs import eds_findings  # it reads with canopen, which takes a while to import

    wrong: set[Finding] = set()
    for place, axis, path in there:
        in_the_file, lacks = eds_findings(path, axis)
        wrong.update(in_the_file)
        wrong.update(document.finding(("can", *place), words) for words in lacks)
    return sorted(wrong)


def _wrap_findings(robot: RobotFile, spec: CanSpec, document: Document) -> list[Finding]:
    """Return findings on axes inside whose travel the counts start over, by the drive's EDS file."""
    if all(axis.eds is None for _, axis in placed_axes(spec)):
        return []
    from .eds_needs import wrap_findings

    places = {axis.node: place for place, axis in placed_axes(spec)}
    return [document.finding(("can", *places[node]), words) for node, words in wrap_findings(robot, spec)]


def _nodes(spec: CanSpec) -> Iterator[tuple[Place, str]]:
    seen = {spec.our_node: "our_node"}
    for (place, axis), (name, _) in zip(placed_axes(spec), spec.axes(), strict=True):
        if axis.node in seen:
            words = f"{seen[axis.node]} and {name} have the node {axis.node}; allowed: each its own"
            yield (*place, "node"), words
        seen[axis.node] = name


def _counts(robot: RobotFile, spec: CanSpec) -> Iterator[tuple[Place, str]]:
    joints = () if robot.arm is None else robot.arm.joints
    if spec.joints and len(spec.joints) != len(joints):
        yield ("joints",), f"{len(spec.joints)} drives for {len(joints)} joints; allowed: one for each"
    for number, (joint, slides) in enumerate(zip(spec.joints, robot.joint_units.slides, strict=False)):
        yield from ((("joints", number, *key), words) for key, words in _joint(joint, slides))
    if spec.gripper is not None and robot.gripper is None:
        yield ("gripper",), "the robot has no gripper; allowed: a drive for a section `gripper`"


def _joint(joint: JointDriveSpec, slides: bool) -> Iterator[tuple[Place, str]]:
    kind = "a joint that slides" if slides else "a joint that turns"
    needed = ("lead_mm", "rated_force_n") if slides else ("rated_torque_nm",)
    for key in needed:
        if getattr(joint, key) is None:
            yield (), f"the key {key!r} is missing; needed: it, for {kind}"
    for key in ("lead_mm", "rated_force_n", "rated_torque_nm"):
        if key not in needed and getattr(joint, key) is not None:
            yield (key,), f"{key} of {kind}; allowed: {', '.join(needed)}"


def _periods(robot: RobotFile, spec: CanSpec) -> Iterator[tuple[Place, str]]:
    if spec.heartbeat_timeout_ms < 2 * spec.heartbeat_ms:
        words = f"heartbeat_timeout_ms is {spec.heartbeat_timeout_ms}"
        yield (), f"{words}; allowed: from twice heartbeat_ms, {2 * spec.heartbeat_ms}"
    period_ms = 1e3 * robot.period_s
    if spec.heartbeat_timeout_ms < 2.0 * period_ms:
        words = (
            f"{spec.heartbeat_timeout_ms} ms, and our heartbeat is sent once in a period of {period_ms:g} ms"
        )
        yield ("heartbeat_timeout_ms",), f"{words}; allowed: from twice that"
    cyclic = [name for name, axis in spec.axes() if getattr(axis, "mode", "") in _CYCLIC]
    if cyclic and not _fits(period_ms):
        words = f"{', '.join(cyclic)}: cyclic modes, with a period of {period_ms:g} ms"
        yield (), f"{words}; allowed: whole milliseconds up to 255, for 60C2h"


def _fits(period_ms: float) -> bool:
    return abs(period_ms - round(period_ms)) < 1e-6 and 1 <= round(period_ms) <= 255


def _files(robot: RobotFile, spec: CanSpec) -> Iterator[tuple[Place, str]]:
    for place, axis in placed_axes(spec):
        if axis.eds is not None and not (robot.folder / axis.eds).is_file():
            yield (*place, "eds"), f"missing file {axis.eds!r}; allowed: one beside the robot's file"


def placed_axes(spec: CanSpec) -> Iterator[tuple[Place, AxisSpec]]:
    """Yield the keys that lead to each drive in the section `can`, such as `("joints", 0)`, and its
    specification.
    """
    yield ("left",), spec.left
    yield ("right",), spec.right
    for number, joint in enumerate(spec.joints):
        yield ("joints", number), joint
    if spec.gripper is not None:
        yield ("gripper",), spec.gripper
