"""Parts of a physics engine that its sensors are built from, next to the scene."""

from __future__ import annotations

from typing import Any, NamedTuple

from handcart.backends.physics.body.robot_body import RobotBody
from handcart.backends.physics.engine.engine import Engine
from handcart.backends.physics.world.world_bodies import WorldBodies
from handcart.backends.simulation.sensors.simulated_sensor import SensorSite


class PhysicsSite(NamedTuple):
    """Engine, robot and world of a backend with physics, which are passed to each simulated sensor when it is
    built.
    """

    engine: Engine
    body: RobotBody
    world: WorldBodies


def physics_of(site: SensorSite[Any]) -> PhysicsSite:
    """Return engine, robot and world of the backend in which a sensor is built.

    Args:
        site: parts of the simulation from which the sensor is built.

    Raises:
        TypeError: the sensor is not built by a backend with physics.
    """
    if not isinstance(site.engine, PhysicsSite):
        raise TypeError(f"the sensor {site.name!r} needs a physics engine")
    return site.engine
