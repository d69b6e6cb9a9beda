"""Types of numbers that may be infinite, such as ranges without an echo, or times of what never happens."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from handcart.robotics.numerics.arrays import FloatArray

MAY_BE_INFINITE = "may be infinite"
"""Annotation of types whose values may be infinite; values of all other types are finite."""

Far: TypeAlias = Annotated[float, MAY_BE_INFINITE]
FarArray: TypeAlias = Annotated[FloatArray, MAY_BE_INFINITE]
