"""The used parts of toppra; matplotlib's pyplot, used only by its plots, is loaded on first use."""

from __future__ import annotations

import sys
from importlib.util import LazyLoader, find_spec, module_from_spec


def _load_when_used(name: str) -> None:
    if name in sys.modules:
        return
    spec = find_spec(name)
    assert spec is not None, f"toppra needs {name}"
    assert spec.loader is not None, f"{name} is a module"
    spec.loader = loader = LazyLoader(spec.loader)
    sys.modules[name] = module = module_from_spec(spec)
    loader.exec_module(module)


_load_when_used("matplotlib.pyplot")

from toppra import SplineInterpolator as SplineInterpolator  # noqa: E402
from toppra.algorithm import TOPPRA as TOPPRA  # noqa: E402
from toppra.constraint import JointAccelerationConstraint as JointAccelerationConstraint  # noqa: E402
from toppra.constraint import JointTorqueConstraint as JointTorqueConstraint  # noqa: E402
from toppra.constraint import JointVelocityConstraint as JointVelocityConstraint  # noqa: E402
from toppra.constraint import JointVelocityConstraintVarying as JointVelocityConstraintVarying  # noqa: E402
from toppra.interpolator import AbstractGeometricPath as AbstractGeometricPath  # noqa: E402
