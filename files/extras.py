"""Libraries that not every robot and task needs: pip installs them as extras of handcart."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.util import find_spec

EXTRA_MODULES: dict[str, Sequence[str]] = {
    "arm": ("pinocchio", "ompl", "toppra", "fcl"),
    "labels": ("onnxruntime", "rapidocr"),
    "sim": ("mujoco",),
    "video": ("av",),
    "pybullet": ("pybullet",),
    "bags": ("mcap", "rosbags"),
    "bddl": ("bddl",),
    "cluster": ("distributed",),
    "export": ("arro3", "foxglove"),
    "view": ("viser", "yourdfpy"),
    "console": ("aiohttp",),
    "xacro": ("xacrodoc",),
    "ros2": ("rclpy",),
}
"""Modules of each extra in pyproject.toml, by the extra's name."""


def extra_of(error: ImportError) -> str | None:
    """Return the name of the optional dependencies ("extra") of handcart that would install a module.

    Args:
        error: failed import of the module.

    Returns:
        The extra's name; None if no extra contains the module.
    """
    module = (error.name or "").partition(".")[0]
    return next((extra for extra, modules in EXTRA_MODULES.items() if module in modules), None)


def lack(who: str, extra: str) -> str | None:
    """Return a message that a part of handcart lacks optional dependencies (an "extra"), and how to install
    them.

    Args:
        who: name of the part in the message.
        extra: name of the extra, a key of `EXTRA_MODULES`.

    Returns:
        The message; None if all modules of the extra are installed.
    """
    missing = [module for module in EXTRA_MODULES[extra] if not is_there(module)]
    if not missing:
        return None
    return f"{who} needs {', '.join(missing)}, not installed; install with: pip install 'handcart[{extra}]'"


def is_there(module: str) -> bool:
    """Return whether a Python module is installed; only its parent package is imported, not the module."""
    try:
        return find_spec(module) is not None
    except (ImportError, ValueError):
        return False
