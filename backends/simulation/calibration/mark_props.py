"""Marks on level surfaces of a simulated world."""

from __future__ import annotations

from collections.abc import Sequence

from typing_extensions import override

from handcart.backends.simulation.world.props import Props

from .mark import Mark
from .spec import MarksSection


class MarkProps(Props[MarksSection]):
    """Printed sheets on level surfaces of a simulated world, such as calibration boards, for its cameras to
    see.
    """

    section = MarksSection

    @override
    def set_up(self) -> None:
        self.marks = tuple(Mark(spec) for spec in self.spec.marks)

    @override
    def sheets(self) -> Sequence[Mark]:
        return self.marks
