"""The sensors in a robot's file: a table, and the older keys that hold one sensor each."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Self, TypeVar

from pydantic import Field, PrivateAttr, SerializeAsAny, model_validator

from handcart.backends.description.beacons_spec import BeaconsSpec
from handcart.backends.description.ground_spec import GpsSpec
from handcart.backends.description.range_spec import RangeSpec
from handcart.backends.description.sensor_specs import CameraSpec, ImuSpec, PositioningSpec
from handcart.files.models.model import FileModel

from .sensor_spec import SensorName, SensorSpec

S = TypeVar("S", bound=SensorSpec)

TABLE_KEY = "sensors"
OLD_KEYS = ("camera", "range_sensor", "imu", "gps", "beacons", "positioning")
"""Keys of a robot's file that hold one sensor, which is called like the key."""


class SensorTable(FileModel):
    """The sensors of a robot's file, from its table `sensors` and from older keys with one sensor each, such
    as `imu`.
    """

    sensors: dict[SensorName, SerializeAsAny[SensorSpec]] = Field(default_factory=dict)
    """Sensors by name: any number of each kind. The first one of a kind is the one that is used where only
    one is needed.
    """
    camera_: Annotated[CameraSpec | None, Field(alias="camera", exclude=True)] = None
    """A sensor `camera` of the kind `camera`."""
    range_sensor_: Annotated[RangeSpec | None, Field(alias="range_sensor", exclude=True)] = None
    """A sensor `range_sensor` of the kind `lidar`."""
    imu_: Annotated[ImuSpec | None, Field(alias="imu", exclude=True)] = None
    """A sensor `imu` of the kind `imu`."""
    positioning_: Annotated[PositioningSpec | None, Field(alias="positioning", exclude=True)] = None
    """A sensor `positioning` of the kind `positioning`."""
    gps_: Annotated[GpsSpec | None, Field(alias="gps", exclude=True)] = None
    """A sensor `gps` of the kind `gps`."""
    beacons_: Annotated[BeaconsSpec | None, Field(alias="beacons", exclude=True)] = None
    """A sensor `beacons` of the kind `beacons`."""

    _old: frozenset[str] = PrivateAttr(default=frozenset())
    """Names of the sensors that the file has under the older keys."""

    @model_validator(mode="after")
    def _one_table(self) -> Self:
        """Move the sensors of the older keys into the table, before the others."""
        old = {key: spec for key in OLD_KEYS if (spec := getattr(self, f"{key}_")) is not None}
        if both := sorted(old.keys() & self.sensors.keys()):
            raise ValueError(f"two sensors are called {both[0]!r}; allowed: a name of its own for each")
        table = {**old, **self.sensors}
        self.__dict__.update({"sensors": table, **{f"{key}_": None for key in old}})
        self._old = frozenset(old)
        return self

    def key_of(self, name: str) -> tuple[str, ...]:
        """Return the keys that lead to a sensor's section in the robot's file, such as `("sensors",
        "lidar")`.
        """
        return (name,) if name in self._old else (TABLE_KEY, name)

    def name_of(self, sensor: SensorSpec) -> str:
        """Return the name of a sensor in the robot's file, given its description, which must be the table's
        own object.
        """
        return next(name for name, spec in self.sensors.items() if spec is sensor)

    def all_of(self, kind: type[S]) -> dict[str, S]:
        """Return the descriptions of all sensors of the class `kind`, by name."""
        return {name: spec for name, spec in self.sensors.items() if isinstance(spec, kind)}

    def first(self, kind: type[S]) -> S | None:
        """Return the description of the first sensor of the class `kind`; None if the robot has none."""
        return next(iter(self.all_of(kind).values()), None)

    @property
    def camera(self) -> CameraSpec | None:
        """Description of the robot's first camera; None without one."""
        return self.first(CameraSpec)

    @property
    def range_sensor(self) -> RangeSpec | None:
        """Description of the robot's first lidar; None without one."""
        return self.first(RangeSpec)

    @property
    def imu(self) -> ImuSpec | None:
        """Description of the robot's first inertial measurement unit; None without one."""
        return self.first(ImuSpec)

    @property
    def positioning(self) -> PositioningSpec | None:
        """Description of the indoor positioning system; None without one."""
        return self.first(PositioningSpec)

    @property
    def gps(self) -> GpsSpec | None:
        """Description of the robot's first satellite receiver; None without one."""
        return self.first(GpsSpec)

    @property
    def beacons(self) -> BeaconsSpec | None:
        """Description of the radio beacons in the robot's file; None if the file has none."""
        return self.first(BeaconsSpec)

    def with_sensors(self, changed: Mapping[str, SensorSpec | None]) -> Self:
        """Return a copy of the table in which some sensors are replaced, added or removed.

        Args:
            changed: description of each changed sensor by its name; None removes the sensor.
        """
        table = {**self.sensors, **changed}
        left = {name: spec for name, spec in table.items() if spec is not None}
        return super().model_copy(update={"sensors": left})

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return a copy in which the attributes named in `update` have new values.

        A key of older versions in `update`, such as `camera`, replaces the first sensor of the kind that the
        key names.
        """
        given = dict(update or {})
        old = {key: given.pop(key) for key in OLD_KEYS if key in given}
        copy = super().model_copy(update=given, deep=deep)
        return copy.with_sensors({copy._name_of(key): spec for key, spec in old.items()}) if old else copy

    def _name_of(self, key: str) -> str:
        """Return the name of the first sensor of the kind of an older key."""
        first = getattr(self, key)
        return next((name for name, spec in self.sensors.items() if spec is first), key)
