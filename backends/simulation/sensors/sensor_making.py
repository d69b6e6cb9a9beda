"""Construction of a robot's simulated sensors from its file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

from handcart.backends.capabilities.capability import Capability
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.sensors.sensor_kind import SensorKind, imported, sensor_kind
from handcart.files.errors import InputError
from handcart.files.suggest import listed

from .simulated_sensor import SensorSite, SimulatedSensor


class NotSimulated(InputError):
    """Error of a robot's file that has a kind of sensor the chosen backend does not simulate."""

    def __init__(self, sensor: str, kind: SensorKind, backend: str) -> None:
        allowed = f"allowed: another backend (it is simulated for {listed(kind.simulated)}), or no {sensor!r}"
        super().__init__(
            f"the sensor {sensor!r} is of the kind {kind.name!r}, which the backend {backend!r} does not "
            f"simulate; {allowed}"
        )


class SensorMaker(NamedTuple):
    """Builder of a simulated sensor, with a flag that the simulated bodies have to come to rest before the
    builder is called.
    """

    build: Callable[[SensorSite[Any]], SimulatedSensor]
    settled_first: bool
    """True if the simulation has to come to rest before."""

    def __call__(self, site: SensorSite[Any]) -> SimulatedSensor:
        """Build the sensor of a site."""
        made = self.build(site)
        if isinstance(made, Capability):
            made.sensor_name = site.name
        return made


def make_sensors(robot: RobotFile, simulations: Sequence[str], backend: str) -> dict[str, SensorMaker]:
    """Return the function that builds each sensor of a robot, by the sensor's name.

    Args:
        robot: robot file.
        simulations: names of simulations that this backend can use, in order of preference; each sensor gets
            the first that exists for its kind.
        backend: name of the backend for messages.

    Raises:
        NotSimulated: a kind of sensor is not simulated for this backend.
        BrokenPlugin: a kind of another package cannot be imported.
    """
    makers = {}
    for name, spec in robot.sensors.items():
        kind = sensor_kind(spec.kind)
        found = next(
            (kind.simulated[simulation] for simulation in simulations if simulation in kind.simulated), None
        )
        if found is None:
            raise NotSimulated(name, kind, backend)
        makers[name] = _maker(found)
    return makers


@cache
def _maker(path: str) -> SensorMaker:
    """Return the maker at an import path: a `SimulatedSensor`, or a function that chooses among several."""
    made = imported(path)
    if isinstance(made, type) and issubclass(made, SimulatedSensor):
        return SensorMaker(made.build, made.SETTLED_FIRST)
    return SensorMaker(made, False)
