"""A robot that a physics engine refuses, with the link or joint that it is about."""

from __future__ import annotations

import re

from handcart.backends.urdf.robot_urdf import RobotUrdf
from handcart.files.errors import FileError, InputError

_NAMED = re.compile(r"'([^']*)'|\"([^\"]*)\"")
MAX_QUOTED_LETTERS = 300  # of what an engine says


class RobotRefused(InputError):
    """Error: a physics engine cannot build a model of the robot."""


def refusal(engine: str, error: Exception, whole: RobotUrdf, prefix: str = "") -> InputError:
    """Translate a physics engine's error about a robot into an error about the robot's files.

    Args:
        engine: name of the engine.
        error: exception of the engine.
        whole: the robot's URDF, with the places of links and joints.
        prefix: prefix of the names of links and joints in the engine.

    Returns:
        A `FileError` at the line of the link or joint that the engine names; `RobotRefused` otherwise.
    """
    said = " ".join(str(error).removeprefix("Error:").split())[:MAX_QUOTED_LETTERS]
    words = f"{engine} refuses the robot: {said}"
    for match in _NAMED.finditer(said):
        name = (match[1] or match[2] or "").removeprefix(prefix)
        for kind in ("link", "joint"):
            if found := whole.finding(kind, name, words):
                return FileError([found])
    return RobotRefused(words)
