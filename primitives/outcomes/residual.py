"""Measured differences between two states of a robot, each with its limit."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from enum import Enum

_OBJECT_LABEL = "object ", " mm"


class ResidualKind(Enum):
    """Quantity whose difference between two states is measured.

    The value of a member is the quantity's label in journals, with its unit.
    """

    BASE_POSITION = "base_mm"
    BASE_HEADING = "base_deg"
    BASE_POSITION_UNCERTAINTY = "base_unsure_mm"
    """Possible unnoticed motion of the base."""
    BASE_HEADING_UNCERTAINTY = "base_unsure_deg"
    """Possible unnoticed turn of the base."""
    JOINTS = "joints_deg"
    """Largest change of a rotating joint."""
    SLIDING_JOINTS = "slides_mm"
    """Largest change of a sliding joint."""
    GRIPPER = "gripper_mm"
    """Change of the opening."""
    HELD = "held"
    """0, or infinity if something was lost or grasped."""
    OBJECT = "object"
    """Distance of an object from its earlier place, in [mm]."""
    OTHER = ""
    """A quantity of another version's journal."""

    @property
    def is_uncertainty(self) -> bool:
        """True if the quantity is the uncertainty of a measurement and not a motion."""
        return self in (ResidualKind.BASE_POSITION_UNCERTAINTY, ResidualKind.BASE_HEADING_UNCERTAINTY)

    @property
    def is_base_offset(self) -> bool:
        """True if the quantity is the distance or turn of the base between the two states."""
        return self in (ResidualKind.BASE_POSITION, ResidualKind.BASE_HEADING)


@dataclass(frozen=True)
class Residual:
    """Difference of one measured quantity between two states of the robot, with the largest allowed value."""

    kind: ResidualKind
    value: float
    """Size in the unit of the kind; infinity for a lost object."""
    limit: float | None
    """Largest value allowed, in the same unit; None in journals of older versions."""
    name: str = ""
    """Name of the object, or label of another version's quantity; empty for the robot's own parts."""

    @property
    def label(self) -> str:
        """Label of the quantity in journals and messages, such as `base_mm` or `object cup mm`."""
        if self.kind is ResidualKind.OBJECT:
            return self.name.join(_OBJECT_LABEL)
        return self.name if self.kind is ResidualKind.OTHER else self.kind.value

    @property
    def is_within(self) -> bool:
        """True if the value is within its limit, or if the limit is unknown (None); False for an unknown
        value (NaN).
        """
        return self.limit is None or self.value <= self.limit

    @property
    def is_motion(self) -> bool:
        """True if a quantity other than an uncertainty is beyond its limit, so that something has moved."""
        return not self.kind.is_uncertainty and not self.is_within

    @classmethod
    def from_label(cls, label: str, value: float, limit: float | None) -> Residual:
        """Return a residual from its label in a journal; value and limit are in the unit that the label
        names.
        """
        start, end = _OBJECT_LABEL
        if label.startswith(start) and label.endswith(end) and len(label) >= len(start + end):
            return cls(ResidualKind.OBJECT, value, limit, label[len(start) : -len(end)])
        kind = next((kind for kind in ResidualKind if kind.value == label), ResidualKind.OTHER)
        if kind in (ResidualKind.OBJECT, ResidualKind.OTHER):
            return cls(ResidualKind.OTHER, value, limit, label)
        return cls(kind, value, limit)


class Residuals(Mapping[str, float]):
    """Differences of measured quantities between two states of the robot; also a mapping from label to
    value.
    """

    def __init__(self, residuals: Iterable[Residual] = ()) -> None:
        """Collect residuals; their order is kept."""
        self._by_label = {residual.label: residual for residual in residuals}

    @property
    def all(self) -> tuple[Residual, ...]:
        """All residuals (differences of measured quantities between two states) in the order in which they
        were given.
        """
        return tuple(self._by_label.values())

    def of(self, kind: ResidualKind) -> Residual | None:
        """Return the residual (difference between two states) of one kind of quantity, such as the base's
        position; None if this quantity was not measured.
        """
        return next((residual for residual in self.all if residual.kind is kind), None)

    @property
    def beyond(self) -> Residuals:
        """Residuals, differences of measured quantities between two states, that are beyond their limits."""
        return Residuals(residual for residual in self.all if not residual.is_within)

    @property
    def moved(self) -> Residuals:
        """Residuals beyond their limits, without residuals that are uncertainties of measurements, which do
        not show that something moved.
        """
        return Residuals(residual for residual in self.all if residual.is_motion)

    @property
    def limits(self) -> dict[str, float | None]:
        """Limit of each residual (difference of a quantity between two states), by the residual's label; None
        if no limit is known.
        """
        return {label: residual.limit for label, residual in self._by_label.items()}

    @property
    def words(self) -> str:
        """Labels and values of all residuals as one text for people, such as `base_mm 312, held inf`."""
        return ", ".join(f"{label} {value:.3g}" for label, value in self.items())

    @property
    def words_with_limits(self) -> str:
        """All residuals with their limits, as text for people, such as `base_mm 312 (at most 25)`."""
        return ", ".join(
            f"{item.label} {item.value:.3g} (at most {math.nan if item.limit is None else item.limit:.3g})"
            for item in self.all
        )

    def __getitem__(self, label: str) -> float:
        return self._by_label[label].value

    def __iter__(self) -> Iterator[str]:
        return iter(self._by_label)

    def __len__(self) -> int:
        return len(self._by_label)

    def __repr__(self) -> str:
        return f"Residuals({self.words})"


NOT_MOVED = Residuals()
"""Residuals of a robot that was not commanded to move: there is nothing to compare."""


def read_residuals(values: Mapping[str, float | None], limits: Mapping[str, float | None]) -> Residuals:
    """Return the residuals of a journal's record.

    Args:
        values: label to value; None means infinity, which JSON does not have.
        limits: label to limit; empty for journals of older versions, which have no limits.
    """
    return Residuals(
        Residual.from_label(label, math.inf if value is None else float(value), limits.get(label))
        for label, value in values.items()
    )
