"""Registry of the kinds of sensors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING, Any

from handcart.files.plugins import BrokenPlugin, entry_points_of, error_words, import_plugin, package_of

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

    from handcart.backends.capabilities.capability import Capability
    from handcart.backends.description.sensor_spec import SensorSpec

ENTRY_POINT_GROUP = "handcart.sensors"
"""Entry points of other packages: the name of a kind, and the path of its `SensorKind`."""
SHIPPED_KINDS = ("lidar", "camera", "positioning", "imu", "gps", "beacons", "depth_camera", "battery")
"""Shipped kinds, each declared in a module of its name in `handcart.backends.sensors.kinds`."""


@dataclass(frozen=True, eq=False)
class SensorKind:
    """Name of a kind of sensor, such as lidar, and the classes that implement it.

    Classes are given by import paths "module:name". Another package declares its kind in an entry point of
    the group `handcart.sensors`.
    """

    name: str
    """Value of the key `kind` in a robot's file."""
    spec: str
    """A `handcart.backends.description.sensor_spec:SensorSpec`: its section in a robot's file."""
    capability: str
    """A `handcart.backends.capabilities.capability:Capability`: its readings."""
    simulated: Mapping[str, str] = field(default_factory=dict)
    """A `handcart.backends.simulation.sensors.simulated_sensor:SimulatedSensor` by simulation: the name of a
    backend, "physics" for each backend with a physics engine, or "scene" for each simulated backend.
    """
    connected: str | None = None
    """A `handcart.backends.can.sensors.connection:Connection`: how the backend `can` reads a real one."""
    checks: str | None = None
    """A sequence of `handcart.evaluation.conformance.checks.check:Check`, for the conformance kit."""
    frames: str | None = None
    """A regular expression for names of links that are its frame, for `handcart check --draft`."""


def sensor_kinds() -> Mapping[str, SensorKind]:
    """Return all kinds of sensors by name: the shipped kinds first, then those of other packages.

    Raises:
        BrokenPlugin: a kind of another package cannot be imported, is not a `SensorKind`, or has the name of
            another kind.
    """
    return {
        name: sensor_kind(name)
        for name in (*SHIPPED_KINDS, *(point.name for point in entry_points_of(ENTRY_POINT_GROUP)))
    }


@cache
def sensor_kind(name: str) -> SensorKind:
    """Return the kind of sensor with a name, without importing other kinds.

    Raises:
        KeyError: no kind has this name.
        BrokenPlugin: the kind belongs to another package, and cannot be imported, is not a `SensorKind`, or
            has the name of another kind.
    """
    points = [point for point in entry_points_of(ENTRY_POINT_GROUP) if point.name == name]
    if name in SHIPPED_KINDS and not points:
        found: SensorKind = imported(f"handcart.backends.sensors.kinds.{name}:KIND")
        return found
    if not points:
        raise KeyError(name)
    what = f"the kind of sensor {name!r}{package_of(points[0])}"
    if name in SHIPPED_KINDS or len(points) > 1:
        raise BrokenPlugin(what, f"there is another kind with the name {name!r}")
    return _loaded(points[0], what)


def _loaded(point: EntryPoint, what: str) -> SensorKind:
    try:
        kind = import_plugin(point.value, what)
    except (ModuleNotFoundError, AttributeError) as missing:
        raise BrokenPlugin(what, error_words(missing)) from None
    if not isinstance(kind, SensorKind):
        raise BrokenPlugin(what, f"{point.value} is not a SensorKind")
    if kind.name != point.name:
        raise BrokenPlugin(what, f"{point.value} is of the kind {kind.name!r}")
    return kind


def imported(path: str) -> Any:
    """Import the object at a path "module:name" that a kind of sensor declares.

    Raises:
        BrokenPlugin: the object cannot be imported.
    """
    return import_plugin(path, "a part of a kind of sensor")


@cache
def sensor_specs() -> Mapping[str, type[SensorSpec]]:
    """Return the class that describes a sensor in a robot's file, for each kind of sensor by name.

    Raises:
        BrokenPlugin: a kind of another package cannot be imported, or its class does not have the kind's name
            as the default of the key `kind`.
    """
    found = {name: imported(kind.spec) for name, kind in sensor_kinds().items()}
    for name, spec in found.items():
        if (default := spec.model_fields["kind"].default) != name:
            what = f"the kind of sensor {name!r}"
            raise BrokenPlugin(what, f"the key `kind` of {spec.__name__} is {default!r} by default")
    return found


@cache
def capability_of(kind: str) -> type[Capability]:
    """Return the class of capability, such as `Camera`, through which sensors of a kind are read."""
    found: type[Capability] = imported(sensor_kind(kind).capability)
    return found


def sensor_capabilities() -> tuple[type[Capability], ...]:
    """Return the classes of capabilities, such as `Camera`, through which sensors of all kinds are read."""
    return tuple(dict.fromkeys(capability_of(name) for name in sensor_kinds()))
