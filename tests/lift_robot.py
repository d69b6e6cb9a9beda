"""The librarian with its arm on a lift: a joint that slides, at its lower limit in every posture."""

from __future__ import annotations

from pathlib import Path

from handcart.backends.description.robot_names import SHIPPED_FOLDER

_LIFT = """<joint name="lift" type="prismatic">
    <axis xyz="0 0 1"/>
    <limit lower="0" upper="0.25" effort="600" velocity="0.12"/>
    <dynamics damping="50" friction="5"/>"""
_DRIVE = "    - {node: 10, counts_per_rev: 65536, gear_ratio: 10, lead_mm: 5, rated_force_n: 900}\n"


def write_lift_robot(folder: Path) -> Path:
    """Write robot file and URDF; gives the robot file's path."""
    source = SHIPPED_FOLDER / "librarian"
    urdf = (source / "librarian.urdf").read_text(encoding="utf-8")
    text = (source / "robot.yaml").read_text(encoding="utf-8")
    for before, after in (
        ("librarian.urdf", "lift.urdf"),
        ("joints: [joint_1", "joints: [lift, joint_1"),
        (
            "acceleration_deg_s2: 171.0\n",
            "acceleration_deg_s2: 171.0\n  slide_speed_mm_s: 100\n  slide_acceleration_mm_s2: 200\n",
        ),
        *(
            (f"    {name}: [", f"    {name}: [0, ")
            for name in ("home", "look_at_tag", "carry", "search_ready")
        ),
        ("    - {node: 11,", _DRIVE + "    - {node: 11,"),
    ):
        assert before in text
        text = text.replace(before, after, 1)
    fixed = '<joint name="column_mount" type="fixed">'
    assert fixed in urdf
    (folder / "lift.urdf").write_text(urdf.replace(fixed, _LIFT), encoding="utf-8")
    path = folder / "robot.yaml"
    path.write_text(text, encoding="utf-8")
    return path
