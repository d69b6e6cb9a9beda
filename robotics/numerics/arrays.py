"""Types of arrays by their elements; shape, unit and frame are stated where an array is taken or returned."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
"""Real numbers in double precision; (n, 2) points in [m] unless stated otherwise."""
SingleArray = NDArray[np.float32]
"""Real numbers in single precision."""
BoolArray = NDArray[np.bool_]
"""Masks: True where something holds."""
IntArray = NDArray[np.int64]
"""Integers: cells, counts, indices."""
Int32Array = NDArray[np.int32]
"""Integers in 32 bits, as OpenCV and SciPy take them."""
Int16Array = NDArray[np.int16]
"""Integers in 16 bits."""
Int8Array = NDArray[np.int8]
"""Small integers: codes."""
Uint16Array = NDArray[np.uint16]
"""Non-negative integers in 16 bits, such as depths in [mm]."""
ByteArray = NDArray[np.uint8]
"""Bytes: pictures, grey (h, w) or BGR (h, w, 3), from 0 (black) to 255."""
IndexArray = NDArray[np.intp]
"""Indices as NumPy returns them."""
