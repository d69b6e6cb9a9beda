"""Templates of new packages, robots and tasks, and how they are written."""

from __future__ import annotations

import keyword
import re
from pathlib import Path
from string import Template
from typing import NamedTuple

from handcart.files.errors import InputError
from handcart.tools.terminal.writing import check_folder, write_text

TEMPLATES_FOLDER = Path(__file__).parent / "templates"
SHIPPED_ROBOTS_FOLDER = Path(__file__).parents[2] / "backends" / "robots"
SUFFIX = ".template"
WHEELS_FILE = "wheels.yaml"  # a robot without lidar
ROBOT_HEAD = "# Two wheels and what its sensors see. Every key: `handcart schema robot`."
WHEELS_TAIL = (
    "\nodometry: {wheel_radius_percent: 0.2, tread_percent: 0.2, slip_percent: 0.2}  # assumed errors\n"
)
NAME_PATTERN = r"[a-z][a-z0-9]*(_[a-z0-9]+)*"


class NotAName(InputError):
    """Error of a name that is invalid for a Python package."""


class FolderInUse(InputError):
    """Error: the folder for a new project contains files."""


class Starter(NamedTuple):
    """Kind of project, task or part that can be created from templates, with its files and next commands."""

    help: str
    parts: tuple[tuple[str, str], ...]
    """Folders of templates, and where below the new folder their files go."""
    next_commands: tuple[str, ...]
    """Commands to try it, in this order; `$folder` is the new folder."""
    worlds: tuple[str, ...] = ()
    """World files below the new folder; next to each of them its map is drawn as `map.yaml`."""
    robots: tuple[str, ...] = ()
    """Robot files below the new folder that are made from the shipped cart; `wheels.yaml` without lidar."""


ROOM_COMMANDS = ("handcart check $folder/room/task.yaml", "handcart run $folder/room/task.yaml")
PACKAGE_COMMANDS = ("pip install -e $folder", "pytest $folder")
KINDS = {
    "project": Starter(
        "a package with a robot, a room, a task, a primitive and its tests, an object to carry, and CI",
        (("project", ""), ("primitive", ""), ("room", "room"), ("objects", "objects")),
        (
            *PACKAGE_COMMANDS,
            *ROOM_COMMANDS,
            "handcart conformance --rehearse $folder/room/task.yaml --primitive $NAME --instants 2",
            "handcart run $folder/objects/task.yaml",
        ),
        ("room/world.yaml", "objects/world.yaml"),
        ("robot/robot.yaml",),
    ),
    "task": Starter(
        "a room with a map, places and a task",
        (("task", ""),),
        ("handcart check $folder/task.yaml", "handcart run $folder/task.yaml"),
        ("world.yaml",),
    ),
    "objects": Starter(
        "an object with a tag, two tables with a map, and a task that carries it",
        (("objects", ""),),
        ("handcart check $folder/task.yaml", "handcart run $folder/task.yaml"),
        ("world.yaml",),
    ),
    "robot": Starter(
        "a robot's file beside its URDF: two wheels and a lidar",
        (),
        ("handcart check $folder/robot.yaml", "handcart run drive_map --robot $folder/robot.yaml"),
        robots=("robot.yaml",),
    ),
    "primitive": Starter(
        "a package with a primitive and its tests",
        (("primitive", ""),),
        (*PACKAGE_COMMANDS, "handcart do $NAME distance_m=1.0 limit_m=10 --robot cart"),
    ),
    "domain": Starter(
        "a package with knowledge, objects, a primitive and a survey",
        (("domain", ""),),
        (
            PACKAGE_COMMANDS[0],
            "handcart make-map $folder/room/world.yaml --out $folder/room/map.yaml",
            *ROOM_COMMANDS,
            PACKAGE_COMMANDS[1],
        ),
    ),
    "backend": Starter(
        "a package with a backend of two wheels, and its tests",
        (("backend", ""),),
        (
            *PACKAGE_COMMANDS,
            "handcart conformance --backend $name --robot $folder/wheels.yaml --part checks",
        ),
        robots=("wheels.yaml",),
    ),
}


def names_of(name: str) -> dict[str, str]:
    """Return the forms of a name that templates contain (such as in capitals), by the placeholder of each
    form.

    Args:
        name: lower case, words joined by `_`.

    Raises:
        NotAName: the name has another form, or is a keyword of Python.
    """
    if not re.fullmatch(NAME_PATTERN, name) or keyword.iskeyword(name):
        raise NotAName(
            f"invalid name {name!r}; allowed: small letters, digits and single `_`, a letter first, "
            "and no word of Python"
        )
    return {
        "name": name,
        "NAME": name.upper(),
        "Name": "".join(word.capitalize() for word in name.split("_")),
        "distribution": name.replace("_", "-"),
        "words": name.replace("_", " "),
    }


def write_new(kind: Starter, name: str, folder: Path) -> list[Path]:
    """Write the files of a new project into a new or empty folder, and return the files' paths.

    Args:
        kind: kind of project.
        name: name of the project, in lower case, with words joined by `_`.
        folder: new or empty folder.

    Raises:
        NotAName: the name cannot be used for a new project.
        FolderInUse: the folder has files in it; nothing is written.
        NotWritable: a file cannot be written.
    """
    names = names_of(name)
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise FolderInUse(f"{folder} is not empty; allowed: a new or an empty folder")
    check_folder(folder)
    written = []
    for part, below in kind.parts:
        source = TEMPLATES_FOLDER / part
        for template in sorted(source.rglob(f"*{SUFFIX}")):
            relative = str(template.relative_to(source)).removesuffix(SUFFIX).replace("NAME", name)
            path = folder / below / relative
            path.parent.mkdir(parents=True, exist_ok=True)
            write_text(path, Template(template.read_text(encoding="utf-8")).substitute(names))
            written.append(path)
    for robot in kind.robots:
        written += write_robot(folder / robot, name)
    return written


def write_robot(path: Path, name: str) -> tuple[Path, Path]:
    """Write a robot's file and its URDF from the shipped cart, and return both paths.

    Args:
        path: robot's file to write; if it is called `wheels.yaml`, the robot gets no lidar.
        name: name of the robot, and of the URDF next to the robot's file.
    """
    cart, urdf = SHIPPED_ROBOTS_FOLDER / "cart", path.with_name(f"{name}.urdf")
    is_blind = path.name == WHEELS_FILE
    dropped = "can|range_sensor" if is_blind else "can"
    text = (cart / "robot.yaml").read_text(encoding="utf-8").replace("cart.urdf", urdf.name)
    text = re.sub(rf"(?m)^({dropped}):.*\n(?:[ \t].*\n|\n)*", "", text)
    text = re.sub(r"\A#.*", ROBOT_HEAD, text)
    if is_blind:
        text = text.replace("localizer: scan               #", "localizer: odometry           #")
        text += WHEELS_TAIL
    path.parent.mkdir(parents=True, exist_ok=True)
    write_text(path, text)
    shape = (cart / "cart.urdf").read_text(encoding="utf-8")
    write_text(urdf, shape.replace('robot name="cart"', f'robot name="{name}"'))
    return path, urdf
