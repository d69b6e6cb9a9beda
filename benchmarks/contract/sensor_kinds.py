"""Count the files that a new kind of sensor needs edited beside its own.

    python -m benchmarks.contract.sensor_kinds [KIND ...]

A kind's own files are the module that declares it, those of its parts, and modules that only these import.
Of all other modules of the program, those are listed that name the kind or one of its parts, in whatever
spelling. By default of the kinds that came with the table of sensors: a kind that the pose is estimated
from, or the hand's camera, is named by everything that uses it.
"""

from __future__ import annotations

import argparse
import re
from functools import cache
from pathlib import Path

import networkx

from handcart.backends.description.sensor_table import SensorTable
from handcart.backends.sensors.sensor_kind import SensorKind, sensor_kinds, sensor_specs

TOPICS_FOLDER = "backends/ros2/"
REPOSITORY_ROOT = Path(__file__).resolve().parents[2]
SOURCE_FOLDERS = (
    "robotics",
    "files",
    "backends",
    "primitives",
    "networks",
    "evaluation",
    "tasks",
    "tools",
    "src",
)


@cache
def modules() -> dict[str, str]:
    """Return the text of each module of the program, by its path from the top of the checkout."""
    paths = (
        path
        for room in SOURCE_FOLDERS
        for path in sorted((REPOSITORY_ROOT / room).rglob("*.py"))
        if path.is_file()
    )
    files = (path for path in paths if not any(part.is_symlink() for part in path.parents))
    return {path.relative_to(REPOSITORY_ROOT).as_posix(): path.read_text(encoding="utf-8") for path in files}


def new_kinds() -> list[str]:
    """Return the kinds that have no older key in a robot's file."""
    fields = SensorTable.model_fields.values()
    old = {spec for spec in sensor_specs().values() for field in fields if spec in _members(field.annotation)}
    return [name for name, spec in sensor_specs().items() if spec not in old]


def _members(annotation: object) -> tuple[object, ...]:
    return getattr(annotation, "__args__", ())


def named_outside(kind: str) -> list[str]:
    """Return the modules besides a kind's own that name it or its parts.

    Primitives are left out: they read sensors, and a new kind edits none of them. So is the backend of ROS 2:
    a kind works on all simulated backends without it, and to have topics is more work (`named_by_topics`).
    """
    return [path for path in _named(kind) if not path.startswith(TOPICS_FOLDER)]


def named_by_topics(kind: str) -> list[str]:
    """Return the modules of the backend of ROS 2 that name a kind or its parts."""
    return [path for path in _named(kind) if path.startswith(TOPICS_FOLDER)]


def _named(kind: str) -> list[str]:
    declared = sensor_kinds()[kind]
    own, parts = own_files(declared), [path.partition(":")[2] for path in _paths(declared)]
    spellings = {kind, *(part for part in parts if part[:1].isupper() and not part.isupper())}
    pattern = re.compile("|".join(rf"(?<![a-z]){name}" for name in sorted(spellings)), re.IGNORECASE)
    others = {path: text for path, text in modules().items() if not path.startswith("primitives/")}
    return [path for path, text in others.items() if path not in own and pattern.search(text)]


def own_files(kind: SensorKind) -> set[str]:
    """Return the modules of a kind: its declaration, its parts, and what only they import."""
    own = {_file(path) for path in _paths(kind)}
    own.add(f"backends/sensors/kinds/{kind.name}.py")
    graph = _imports()
    while True:
        more = {
            path
            for path in graph
            if path not in own and (users := set(graph.predecessors(path))) and users <= own
        }
        if not more:
            return own
        own |= more


@cache
def _imports() -> networkx.DiGraph[str]:
    """Return which module imports which, by their paths."""
    graph: networkx.DiGraph[str] = networkx.DiGraph()
    for path, text in modules().items():
        for module in re.findall(r"^\s*from (\S+) import", text, re.MULTILINE):
            found = _target(path, module)
            if found in modules():
                graph.add_edge(path, found)
    return graph


def _target(path: str, module: str) -> str:
    """Return the file of an imported module, absolute or relative to the importing one."""
    if module.startswith("."):
        dots = len(module) - len(module.lstrip("."))
        return "/".join([*path.split("/")[:-dots], *module.lstrip(".").split(".")]) + ".py"
    return module.removeprefix("handcart.").replace(".", "/") + ".py"


def _paths(kind: SensorKind) -> list[str]:
    others = (path for path in (kind.connected, kind.checks) if path is not None)
    return [kind.spec, kind.capability, *kind.simulated.values(), *others]


def _file(path: str) -> str:
    return path.partition(":")[0].removeprefix("handcart.").replace(".", "/") + ".py"


def main() -> None:
    """Print a line for each kind."""
    words = argparse.ArgumentParser(
        prog="python -m benchmarks.contract.sensor_kinds", description=(__doc__ or "").split("\n")[0]
    )
    words.add_argument("kind", nargs="*", default=new_kinds(), help="default: all without an older key")
    for kind in words.parse_args().kind:
        found = named_outside(kind)
        topics = named_by_topics(kind)
        print(f"{kind}: files edited outside its own: {len(found)} ({', '.join(found) or 'none'})")
        print(f"{kind}: files of its topics of ROS 2: {len(topics)} ({', '.join(topics) or 'none'})")


if __name__ == "__main__":
    main()
