"""Faults that another fault hides: behind a duplicate key, or in files that are read later."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import check_world
from handcart.files.errors import FileError, Finding, InputError, UnsafePath
from handcart.files.maps.map_file import load_map
from handcart.files.yaml.yaml_document import Document, read_document, reading_past
from handcart.files.yaml.yaml_node import KeyPath

from .named_files import named_robot, resolved, robot_faults, with_set
from .task_file import Primitives, load_task
from .task_model import MAX_TASK_BYTES, MAX_TASK_NODES

Reading = Callable[[], object]


def with_hidden(error: FileError, readings: Callable[[], Iterator[Reading]]) -> FileError:
    """Return an error with the faults that its own faults hid.

    Args:
        error: faults that ended the first reading.
        readings: function that yields functions, each of which reads a file, and raises its faults.
    """
    passed: list[Finding] = []
    found: list[Finding] = []
    with reading_past(passed):
        try:
            for reading in readings():
                found += _faults(reading)
        except FileError as other:
            found += other.findings
        except InputError:
            pass  # the first reading has reported it
    # A value that YAML refuses is no number either: one finding for each place is enough.
    known = [*error.findings, *passed]
    places = {(item.file, item.line, item.column) for item in known}
    new = [item for item in found if (item.file, item.line, item.column) not in places]
    return FileError([*known, *new])


def files_of(
    task_path: Path | str, settings: Mapping[str, str] | None, primitives: Primitives
) -> Iterator[Reading]:
    """Yield the readings of a task and of the robot, world and map that it names."""
    yield lambda: load_task(task_path, settings, primitives)
    document = read_document(task_path, max_bytes=MAX_TASK_BYTES, max_nodes=MAX_TASK_NODES)
    document = with_set(document, dict(settings or {}))
    if not any(robot_faults(document)):
        robot = document.root.child("robot")
        if robot is not None and isinstance(robot.content, str):
            name = named_robot(document, robot.content)
            yield lambda: load_robot(name)
    if (world := _existing(document, ("world",))) is not None:
        yield lambda: check_world(world, None)
    if (chart := _existing(document, ("knowledge", "map"))) is not None:
        yield lambda: load_map(chart)


def _existing(document: Document, key: KeyPath) -> Path | None:
    """Return the path of a file that a task names; None for a file that is missing or may not be read."""
    try:
        path = resolved(document, key)
    except UnsafePath:
        return None
    return path if path is not None and path.is_file() else None


def _faults(reading: Reading) -> tuple[Finding, ...]:
    try:
        reading()
    except FileError as error:
        return error.findings
    except InputError:
        return ()
    return ()
