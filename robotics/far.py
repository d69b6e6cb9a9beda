"""Numbers that may be infinite: where nothing is, or what never comes."""

from __future__ import annotations

from typing import Annotated, TypeAlias

import numpy as np
from numpy.typing import NDArray

MAY_BE_INFINITE = "may be infinite"
"""Says so of a type; whatever doesn't is finite."""

Far: TypeAlias = Annotated[float, MAY_BE_INFINITE]
FarArray: TypeAlias = Annotated[NDArray[np.float64], MAY_BE_INFINITE]
