"""Robots by name: the shipped ones, and those of other packages.

A package adds its robots by an entry point of the group `handcart.robots`. The entry point names a package;
each folder in it with a `robot.yaml` is a robot called ENTRY_POINT/FOLDER, other YAML files there are its
variants.
"""

from __future__ import annotations

from pathlib import Path

from handcart.files.errors import FileError, Finding
from handcart.files.plugins import plugin_folders
from handcart.files.suggest import suggest

ENTRY_POINT_GROUP = "handcart.robots"
ROBOT_FILE = "robot.yaml"
SHIPPED_FOLDER = Path(__file__).parent.parent / "robots"


def named_robots() -> dict[str, Path]:
    """Return the paths of the files of all robots that have a name, by name in alphabetical order.

    A shipped robot is named ROBOT, a variant of it ROBOT/VARIANT. Robots of another package are named
    OWNER/ROBOT and OWNER/ROBOT/VARIANT. No package can replace a shipped name.
    """
    robots = _robots_below(SHIPPED_FOLDER, "")
    for owner, folder in plugin_folders(ENTRY_POINT_GROUP).items():
        robots = _robots_below(folder, f"{owner}/") | robots
    return dict(sorted(robots.items()))


def robot_path(name: str) -> Path:
    """Return the path of a robot's file, given the robot's name or the path itself.

    Raises:
        FileError: the text is not the path of a YAML file, and no robot has this name.
    """
    if is_robot_path(name):
        return Path(name)
    path = find_robot(name)
    if path is None:
        wrong = f"unknown robot{suggest(name, named_robots())}, or the path of a robot's YAML file"
        raise FileError([Finding(name, 0, 0, wrong)])
    return path


def find_robot(name: str) -> Path | None:
    """Return the path of the file of the robot with the given name; None if no robot has this name.

    Other installed packages are searched only for a name that is not shipped.
    """
    return _robots_below(SHIPPED_FOLDER, "").get(name) or named_robots().get(name)


def is_robot_path(name: str) -> bool:
    """Return True if the text is the path of a robot's YAML file, by its suffix, and not a robot's name."""
    return name.endswith((".yaml", ".yml"))


def _robots_below(folder: Path, prefix: str) -> dict[str, Path]:
    robots = [path.parent for path in folder.glob(f"*/{ROBOT_FILE}")]
    return {_name(path, prefix): path for robot in robots for path in robot.glob("*.yaml")}


def _name(path: Path, prefix: str) -> str:
    folder = f"{prefix}{path.parent.name}"
    return folder if path.name == ROBOT_FILE else f"{folder}/{path.stem}"
