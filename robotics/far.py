"""Numbers that may be infinite: where nothing is, or what never comes."""

from __future__ import annotations

from typing import Annotated, TypeAlias

import numpy as np
from numpy.typing import NDArray

FAR = "may be infinite"
"""Says so of a type; whatever doesn't is finite."""

Far: TypeAlias = Annotated[float, FAR]
FarArray: TypeAlias = Annotated[NDArray[np.float64], FAR]
