"""The used parts of toppra; matplotlib's pyplot, used only by its plots, is loaded on first use."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module
from types import ModuleType
from typing import Any


class _LoadedOnUse(ModuleType):
    """Placeholder of a module that is loaded when one of its attributes is first used.

    `importlib.util.LazyLoader` is no substitute: up to Python 3.11, importing a module that is there
    already reads its `__spec__`, and this loads it.
    """

    def __getattr__(self, name: str) -> Any:
        return getattr(import_module(self.__name__), name)


_package, _plots = ModuleType("matplotlib"), _LoadedOnUse("matplotlib.pyplot")
_package.pyplot = _plots  # type: ignore[attr-defined]
_stand_ins = {part.__name__: part for part in (_package, _plots) if part.__name__ not in sys.modules}
sys.modules.update(_stand_ins)

from toppra import SplineInterpolator as SplineInterpolator  # noqa: E402
from toppra.algorithm import TOPPRA  # noqa: E402
from toppra.algorithm.algorithm import ParameterizationAlgorithm  # noqa: E402
from toppra.constraint import JointAccelerationConstraint as JointAccelerationConstraint  # noqa: E402
from toppra.constraint import JointTorqueConstraint as JointTorqueConstraint  # noqa: E402
from toppra.constraint import JointVelocityConstraint as JointVelocityConstraint  # noqa: E402
from toppra.constraint import JointVelocityConstraintVarying as JointVelocityConstraintVarying  # noqa: E402
from toppra.interpolator import AbstractGeometricPath as AbstractGeometricPath  # noqa: E402
from toppra.solverwrapper import seidelWrapper  # noqa: E402

from handcart.robotics.numerics.arrays import FloatArray  # noqa: E402

for name in _stand_ins:
    del sys.modules[name]


class SeidelToppra(TOPPRA):  # type: ignore[misc]
    """Time-optimal path parametrization TOPP-RA with Seidel's solver, which is compiled into the library
    toppra.

    It replaces toppra's constructor, which searches the disk for other solvers each time.
    """

    def __init__(self, constraints: Sequence[object], path: AbstractGeometricPath, grid: FloatArray) -> None:
        """Take linear constraints, a path, and its arc lengths (g,), from the path's start to its end."""
        ParameterizationAlgorithm.__init__(self, list(constraints), path, gridpoints=grid)
        self.solver_wrapper = seidelWrapper(self.constraints, self.path, self.gridpoints, solve_lp1d=True)
