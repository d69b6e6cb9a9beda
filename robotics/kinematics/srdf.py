"""Reading of the links that may touch from an SRDF, MoveIt's file next to a URDF."""

from __future__ import annotations

from handcart.robotics.kinematics.urdf_reading import UrdfFaults, read_xml


def disabled_pairs(text: str) -> list[tuple[str, str]]:
    """Return the pairs of links that an SRDF excludes from collision checks, by `disable_collisions`.

    Raises:
        UrdfFaults: the text is not an SRDF, or a pair lacks a link.
    """
    robot = read_xml(text)
    if robot.tag != "robot":
        raise UrdfFaults([robot.fault(f"the SRDF's root is <{robot.tag}>; allowed: <robot>")])
    found = []
    for item in robot.iter("disable_collisions"):
        first, second = item.get("link1", ""), item.get("link2", "")
        if not (first and second):
            wrong = "a <disable_collisions> names no two links; needed: link1=... and link2=..."
            raise UrdfFaults([item.fault(wrong)])  # type: ignore[attr-defined]
        found.append((first, second))
    return found
