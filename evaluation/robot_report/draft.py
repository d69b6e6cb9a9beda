"""A first robot.yaml for a URDF: what the URDF tells, and what is to be measured."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from handcart.backends.description.joint_units import JointUnits
from handcart.robotics.kinematics.urdf_contents import JointFacts

from .outline import Outline

RADIUS, TREAD = 0.1, 0.5  # of wheels that the URDF doesn't tell [m]
UNKNOWN = "measure"
GUESSED = "by the URDF; measure"


def draft_text(outline: Outline, joints: Sequence[JointFacts], urdf: str) -> str:
    """The text of a robot's file.

    Args:
        outline: of the robot.
        joints: its joints that move.
        urdf: its URDF, as the file is to name it.
    """
    lines = [
        "# Made by `handcart check` from the URDF alone; what is marked is to be measured or chosen.",
        "format: handcart-robot/1",
        f"urdf: {_quoted(urdf)}",
        *_links(outline),
        "period_s: 0.05",
        "footprint_radius_m: 0.5        # measure: of the circle about `base` that holds base, arm and load",
        "localizer: odometry            # scan: with a range sensor",
        *_drive(outline),
        *_arm(outline, {each.name: each for each in joints}),
        "tolerance: {base_mm: 25, base_deg: 1.5, joints_deg: 0.3, gripper_mm: 1, object_mm: 8}     # choose",
    ]
    return "\n".join(lines) + "\n"


def _links(outline: Outline) -> list[str]:
    named = {"base": outline.root} if outline.root != "base" else {}
    if outline.arm and outline.hand != "hand":
        named["hand"] = outline.hand
    inner = ", ".join(f"{role}: {_quoted(link)}" for role, link in named.items())
    return [f"links: {{{inner}}}"] if named else []


def _drive(outline: Outline) -> list[str]:
    wheels = outline.wheels
    lines = ["drive:"]
    if wheels is not None:
        sides = {"left": wheels.left, "right": wheels.right}
        lines += [f"  {s}: {_flow(names)}" for s, names in sides.items() if names != (f"{s}_wheel",)]
    radius = None if wheels is None else wheels.radius
    tread = None if wheels is None else wheels.tread
    for key, value, otherwise in (("wheel_radius_m", radius, RADIUS), ("tread_m", tread, TREAD)):
        known = value is not None and value > 0.0
        lines.append(f"  {key}: {value if known else otherwise:.4g}     # {GUESSED if known else UNKNOWN}")
    limits = "top_speed_m_s: 0.5|top_turn_deg_s: 60|acceleration_m_s2: 0.5|turn_acceleration_deg_s2: 90"
    return lines + [f"  {each}     # choose" for each in limits.split("|")]


def _arm(outline: Outline, facts: dict[str, JointFacts]) -> list[str]:
    if not outline.arm:
        return []
    kinds = [facts[name].kind for name in outline.arm]
    units = JointUnits(
        outline.arm, tuple(k == "prismatic" for k in kinds), tuple(k == "continuous" for k in kinds)
    )
    home = units.user_units([_middle(facts[name]) for name in outline.arm])
    lines = ["arm:", f"  joints: {_flow(outline.arm)}", "  top_speed_deg_s: 30     # choose"]
    lines.append("  acceleration_deg_s2: 60     # choose")
    if any(units.slides):
        lines += ["  slide_speed_mm_s: 50     # choose", "  slide_acceleration_mm_s2: 100     # choose"]
    numbers = ", ".join(f"{value + 0.0:.6g}" for value in np.trunc(np.array(home) * 10.0) / 10.0)
    return [*lines, "  postures:", f"    home: [{numbers}]     # [{units.all}]; teach a better one"]


def _middle(joint: JointFacts) -> float:
    """Zero, where the limits allow it; else midway."""
    if joint.kind == "continuous" or joint.lower is None or joint.upper is None:
        return 0.0
    return 0.0 if joint.lower <= 0.0 <= joint.upper else 0.5 * (joint.lower + joint.upper)


def _flow(names: Sequence[str]) -> str:
    return f"[{', '.join(_quoted(name) for name in names)}]"


def _quoted(name: str) -> str:
    """As YAML reads it as a string, whatever it is."""
    return '"' + name.replace("\\", "\\\\").replace('"', '\\"') + '"'
