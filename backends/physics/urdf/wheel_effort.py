"""Torque of driven wheels whose URDF states none, as is legal for continuous joints."""

from __future__ import annotations

from collections.abc import Collection
from xml.etree import ElementTree
from xml.etree.ElementTree import SubElement

from handcart.backends.physics.engine.engine import GRAVITY_M_S2
from handcart.backends.physics.engine.surface import TYRE_SURFACE
from handcart.robotics.kinematics.urdf_contents import joints_of, links_of


def slipping_torque(mass: float, radius: float, wheels: int) -> float:
    """Return the torque at which a tyre slips if the driven wheels share the robot's weight, in [Nm].

    Args:
        mass: mass of the robot, in [kg].
        radius: radius of the wheels, in [m].
        wheels: number of driven wheels.
    """
    assert TYRE_SURFACE.friction is not None
    return TYRE_SURFACE.friction * mass * GRAVITY_M_S2 * radius / wheels


def with_wheel_efforts(urdf: str, wheels: Collection[str], radius: float) -> str:
    """Return a URDF in which driven wheels without an effort limit get one: the torque at which their tyres
    slip.

    The friction and damping of these wheels' joints are removed, so that the full torque acts at the tyre.

    Args:
        urdf: URDF of the robot.
        wheels: names of the joints of the driven wheels.
        radius: radius of the wheels, in [m].
    """
    limp = {item.name for item in joints_of(urdf) if item.name in wheels and item.effort <= 0.0}
    if not limp:
        return urdf
    mass = sum(facts.mass or 0.0 for facts in links_of(urdf))
    torque = slipping_torque(mass, radius, len(wheels))
    robot = ElementTree.fromstring(urdf)
    for joint in robot.findall("joint"):
        if joint.get("name") in limp:
            limit = joint.find("limit")
            limit = SubElement(joint, "limit") if limit is None else limit
            limit.set("effort", repr(torque))
            for dynamics in joint.findall("dynamics"):
                joint.remove(dynamics)
    return ElementTree.tostring(robot, encoding="unicode")
