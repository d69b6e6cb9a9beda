"""Backend that wraps another one: the base of injected faults and mutant backends."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from typing_extensions import override

from handcart.backends.backend import Backend
from handcart.backends.capabilities.arm import ForceArm
from handcart.backends.capabilities.base import HolonomicBase
from handcart.backends.capabilities.capability import Capability
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.sensors.all_kinds import all_capabilities

Kind = type[Capability]


class LayeredBackend(Backend):
    """Base class of backends that wrap another backend and change some of its readings or commands.

    Each capability of the inner backend is wrapped in an object that calls this backend. A method
    `arm_move(arm, joints)` of a subclass is called instead of `Arm.move(joints)`,
    `range_sensor_scan(sensor)` instead of `RangeSensor.scan()` and so on; its first argument is the inner
    capability. Capabilities of kinds that are not in `all_capabilities` are not wrapped.
    """

    def __init__(self, inner: Backend) -> None:
        self._inner = inner
        self.name, self.period = inner.name, inner.period
        self._layers = tuple(self._layer(part) for part in inner.capabilities())

    @property
    def inner(self) -> Backend:
        """Backend that this backend wraps, and whose readings or commands it changes."""
        return self._inner

    def _layer(self, part: Capability) -> Capability:
        kind = next((kind for kind in all_capabilities() if isinstance(part, kind)), None)
        if kind is None:
            return part
        layer: Capability = layered_kind(kind, provided_kind(part, kind))(self, part)
        return layer

    def pass_on(self, part: Capability, kind: Kind, method: str, *words: Any) -> Any:
        """Call a method of the wrapped backend's capability, or the method of this backend that replaces it.

        Args:
            part: capability of the wrapped backend.
            kind: kind of the capability; the name of a replacing method begins with the kind's name, such as
                `range_sensor_scan`.
            method: name of the method.
            *words: arguments of the call.
        """
        own = getattr(self, f"{kind.words().replace(' ', '_')}_{method}", None)
        return getattr(part, method)(*words) if own is None else own(part, *words)

    @classmethod
    def build(cls, robot: RobotFile, world: Path | None, seed: int) -> Backend:
        """Raise a TypeError, because a layer wraps an existing backend and is never built from its name."""
        raise TypeError(f"{cls.__name__} is made around another backend")

    @override
    def capabilities(self) -> tuple[Capability, ...]:
        return self._layers

    @override
    def step(self) -> None:
        self.inner.step()

    @override
    def stop(self) -> None:
        self.inner.stop()

    @override
    def close(self) -> None:
        self.inner.close()


EXTENDED_KINDS: tuple[Kind, ...] = (HolonomicBase, ForceArm)
"""Interfaces that extend a kind of capability: a part may provide one of them instead of its kind."""


def provided_kind(part: Capability, kind: Kind) -> Kind:
    """Return the interface that a capability implements: `kind`, or one of `EXTENDED_KINDS` that extends
    it.
    """
    return next((kind_ for kind_ in EXTENDED_KINDS if isinstance(part, kind_)), kind)


@cache
def layered_kind(kind: Kind, provided: Kind) -> Callable[[Any, Any], Any]:
    """Return a class that wraps capabilities of a kind and routes their methods through a `LayeredBackend`.

    An instance is made from the layered backend and from the capability to be wrapped. All calls go to the
    backend's method `pass_on`; `sensor_name` and the properties are those of the wrapped capability.
    """
    names = sorted(kind.__abstractmethods__ | {name for name in dir(kind) if _is_property(kind, name)})
    methods = {name: _passing(kind, name) for name in names}
    return type(f"Layered{kind.__name__}", (provided,), {"__init__": _begin, **methods})


def _begin(self: Any, whole: LayeredBackend, inner: Capability) -> None:
    self.whole, self.inner, self.sensor_name = whole, inner, inner.sensor_name


def _is_property(kind: Kind, name: str) -> bool:
    return isinstance(getattr(kind, name), property)


def _passing(kind: Kind, name: str) -> Any:
    if _is_property(kind, name):
        return property(lambda self: getattr(self.inner, name))
    return lambda self, *words: self.whole.pass_on(self.inner, kind, name, *words)
