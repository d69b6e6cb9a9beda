"""Numbers that may be infinite: where nothing is, or what never comes."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from handcart.robotics.numerics.arrays import FloatArray

MAY_BE_INFINITE = "may be infinite"
"""Says so of a type; whatever doesn't is finite."""

Far: TypeAlias = Annotated[float, MAY_BE_INFINITE]
FarArray: TypeAlias = Annotated[FloatArray, MAY_BE_INFINITE]
