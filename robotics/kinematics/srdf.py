"""What a SRDF, MoveIt's file beside a URDF, says of links that may touch."""

from __future__ import annotations

from handcart.robotics.kinematics.urdf_reading import UrdfFaults, read_xml


def disabled_pairs(text: str) -> list[tuple[str, str]]:
    """Pairs of links that need no check against each other, as `disable_collisions` has them.

    Raises:
        UrdfFaults: the text is no SRDF, or a pair lacks a link.
    """
    robot = read_xml(text)
    if robot.tag != "robot":
        raise UrdfFaults([robot.fault(f"the SRDF's root is <{robot.tag}>; allowed: <robot>")])
    found = []
    for each in robot.iter("disable_collisions"):
        first, second = each.get("link1", ""), each.get("link2", "")
        if not (first and second):
            wrong = "a <disable_collisions> names no two links; needed: link1=... and link2=..."
            raise UrdfFaults([each.fault(wrong)])  # type: ignore[attr-defined]
        found.append((first, second))
    return found
