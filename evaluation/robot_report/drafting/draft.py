"""Draft of robot.yaml for a URDF: known values, and marks on values that have to be measured or chosen."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from handcart.backends.description.joint_units import JointUnits
from handcart.evaluation.robot_report.outline import Outline, Wheels
from handcart.files.extras import lack
from handcart.robotics.kinematics.urdf_contents import JointFacts, joints_of

from .home_posture import Home, home_of, middle_of, radius_of

GUESSED_TEXT = "by the URDF; measure"
DEFAULT_FOOTPRINT_M = 0.5  # for a robot without collision bodies
FLOOR_TOLERANCE_M = 0.01
CAMERA_SECTION = "{width_px: 640, height_px: 480, focal_px: 600}"
LIDAR_SECTION = "beams: 360, reach_m: 8, sigma_mm: 20"
OPTIONAL_SECTIONS = ("gripper", "camera", "range_sensor")
"""Sections that a draft can omit if their content does not fit the URDF."""


def draft_text(
    outline: Outline,
    urdf_text: str,
    urdf: str,
    left_out: Mapping[str, str] | None = None,
    hidden: Mapping[str, tuple[int, int]] | None = None,
) -> str:
    """Return the text of a draft of a robot's file, with values guessed from the robot's URDF.

    Args:
        outline: wheels, arm, hand and sensors of the robot.
        urdf_text: the robot's URDF.
        urdf: name of the URDF in the file.
        left_out: omitted sections with the reason, which is written as a comment.
        hidden: links of the robot that its lidar sees, each with a sector from and to in [deg].
    """
    without = dict(left_out or {})
    facts = {item.name: item for item in joints_of(urdf_text)}
    units, home = _units(outline, facts), None
    if outline.arm and lack("an arm", "arm") is None:
        arm = [facts[name] for name in outline.arm]
        home = home_of(urdf_text, outline.root, outline.hand, arm, units)
    radius = home.radius if home is not None else radius_of(urdf_text, outline.root)
    scans = _has_range_sensor(outline) and "range_sensor" not in without
    lines = [
        "# Made by `handcart check` from the URDF alone; what is marked is to be measured or chosen.",
        "format: handcart-robot/1",
        f"urdf: {_quoted(urdf)}",
        *_links(outline, without),
        *_contacts(home),
        "period_s: 0.05",
        f"footprint_radius_m: {_footprint(radius):g}     # {_farthest(home)}; measure",
        f"localizer: {'scan     # needs a map; or odometry' if scans else 'odometry'}",
        *_drive(outline, urdf),
        *_arm(outline, facts, units, home),
        *_gripper(outline, facts, without),
        *_sensors(outline, without, dict(hidden or {})),
        "tolerance: {base_mm: 25, base_deg: 1.5, joints_deg: 0.3, gripper_mm: 1, object_mm: 8}     # choose",
    ]
    return "\n".join(lines) + "\n"


def _links(outline: Outline, without: Mapping[str, str]) -> list[str]:
    lines = []
    if outline.root != "base" or _off_the_floor(outline):
        off = (
            f"     # {outline.height:.3f} m above the floor: needed: a frame on it"
            if _off_the_floor(outline)
            else ""
        )
        lines.append(f"  base: {_quoted(outline.root)}{off}")
    if outline.arm:
        lines.append(f"  hand: {_quoted(outline.hand)}     # x has to be the direction of approach")
    for role in ("range_sensor", "camera"):
        found = outline.sensors.get(role)
        if found is not None and not found.between and role not in without and found.link != role:
            lines.append(f"  {role}: {_quoted(found.link)}")
    return ["links:", *lines] if lines else []


def _off_the_floor(outline: Outline) -> bool:
    return outline.height is not None and abs(outline.height) > FLOOR_TOLERANCE_M


def _contacts(home: Home | None) -> list[str]:
    if home is None or not home.always:
        return []
    pairs = [f"  - {_flow(pair)}" for pair in home.always]
    return ["allowed_contacts:     # their hulls touch however the arm is; look whether they may", *pairs]


def _footprint(radius: float) -> float:
    return math.ceil(100.0 * radius) / 100.0 if radius > 0.0 else DEFAULT_FOOTPRINT_M


def _farthest(home: Home | None) -> str:
    if home is None or not home.farthest:
        return "by the URDF"
    return f"by the URDF, the arm in `home`: {home.farthest} is farthest out"


def _drive(outline: Outline, urdf: str) -> list[str]:
    wheels = outline.wheels
    if wheels is None:
        return [
            "# drive: the URDF has no two sides of wheels. For an arm: name its base's URDF above, and add",
            "# parts:",
            f"#   - {{urdf: {_quoted(urdf)}, onto: base, xyz_m: [0, 0, 0.5]}}",
        ]
    sides = {"left": wheels.left, "right": wheels.right}
    lines = [f"  {side}: {_flow(names)}" for side, names in sides.items() if names != (f"{side}_wheel",)]
    if wheels.radius is not None and wheels.radius > 0.0:
        lines.append(f"  wheel_radius_m: {wheels.radius:.4g}     # {GUESSED_TEXT}")
    else:
        lines.append("  wheel_radius_m: 0.1     # measure: the URDF's wheels have no bodies")
    lines += _tread(wheels)
    limits = "top_speed_m_s: 0.5|top_turn_deg_s: 60|acceleration_m_s2: 0.5|turn_acceleration_deg_s2: 90"
    return ["drive:", *lines, *(f"  {part}     # choose" for part in limits.split("|"))]


def _tread(wheels: Wheels) -> list[str]:
    """Return the lines of the kind of the drive and its tread."""
    if wheels.drives_sideways:
        tread = wheels.tread + wheels.wheelbase
        return [
            "  kind: holonomic     # by the names of its wheels or links",
            f"  tread_m: {tread:.4g}     # {GUESSED_TEXT}: track and wheelbase together; of omni wheels the"
            " diameter of their circle",
        ]
    if len(wheels.left) > 1 or len(wheels.right) > 1:
        why = "measure: wheels that slide sideways turn the base by less than their distance says"
        return [f"  tread_m: {wheels.tread:.4g}     # {why}"]
    return [f"  tread_m: {wheels.tread:.4g}     # {GUESSED_TEXT}"]


def _units(outline: Outline, facts: Mapping[str, JointFacts]) -> JointUnits:
    kinds = [facts[name].kind for name in outline.arm]
    slides, endless = (tuple(kind == wanted for kind in kinds) for wanted in ("prismatic", "continuous"))
    return JointUnits(outline.arm, slides, endless)


def _arm(
    outline: Outline, facts: Mapping[str, JointFacts], units: JointUnits, home: Home | None
) -> list[str]:
    if not outline.arm:
        return []
    lines = ["arm:", f"  joints: {_flow(outline.arm)}", "  top_speed_deg_s: 30     # choose"]
    lines.append("  acceleration_deg_s2: 60     # choose")
    if any(units.slides):
        lines += ["  slide_speed_mm_s: 50     # choose", "  slide_acceleration_mm_s2: 100     # choose"]
    middle = units.user_units([middle_of(facts[name]) for name in outline.arm])
    posture = middle if home is None else home.posture
    numbers = ", ".join(f"{math.trunc(10.0 * value) / 10.0 + 0.0:.6g}" for value in posture)
    free = (
        "free of the robot itself" if home is not None and home.is_free else "it may touch the robot itself"
    )
    return [*lines, "  postures:", f"    home: [{numbers}]     # [{units.all}]; {free}; teach a better one"]


def _gripper(outline: Outline, facts: Mapping[str, JointFacts], without: Mapping[str, str]) -> list[str]:
    if outline.turning_fingers:
        names = ", ".join(outline.turning_fingers[:4]) + (" ..." if len(outline.turning_fingers) > 4 else "")
        return [f"# gripper: {names}: they turn; only two fingers that slide can be used. They stay at zero"]
    if outline.fingers is None:
        return []
    if "gripper" in without:
        return [f"# gripper: {without['gripper']}"]
    left, right = outline.fingers
    opening = 2e3 * (facts[left].upper or 0.0)
    inner = f"left: {_quoted(left)}, right: {_quoted(right)}, opening_mm: {opening:.4g}, speed_mm_s: 50"
    return [f"gripper: {{{inner}, force_n: 40}}     # choose"] if opening > 0.0 else []


def _has_range_sensor(outline: Outline) -> bool:
    found = outline.sensors.get("range_sensor")
    return found is not None and not found.between


def _sensors(
    outline: Outline, without: Mapping[str, str], hidden: Mapping[str, tuple[int, int]]
) -> list[str]:
    lines = []
    for role, section, onto in (("range_sensor", "", "base"), ("camera", CAMERA_SECTION, "hand")):
        found = outline.sensors.get(role)
        if role in without:
            lines.append(f"# {role}: {without[role]}")
        elif found is not None and found.between:
            lines.append(f"# {role}: {found.link} moves against the {onto}: only one fixed on it can be used")
        elif found is not None and role == "range_sensor":
            lines += _range_sensor(hidden)
        elif found is not None and outline.arm:
            lines.append(f"{role}: {section}     # by its data sheet")
    return lines


def _range_sensor(hidden: Mapping[str, tuple[int, int]]) -> list[str]:
    if not hidden:
        return [f"range_sensor: {{{LIDAR_SECTION}}}     # by its data sheet"]
    sectors = ", ".join(f"[{start}, {end}]" for start, end in dict.fromkeys(hidden.values()))
    names = ", ".join(hidden)
    return [
        "range_sensor:     # by its data sheet",
        *(f"  {part}" for part in LIDAR_SECTION.split(", ")),
        f"  masked_deg: [{sectors}]     # by the URDF it sees the robot itself: {names}; look at a scan",
    ]


def _flow(names: Sequence[str]) -> str:
    return f"[{', '.join(_quoted(name) for name in names)}]"


def _quoted(name: str) -> str:
    """Return a name as a YAML string in double quotes."""
    return '"' + name.replace("\\", "\\\\").replace('"', '\\"') + '"'
