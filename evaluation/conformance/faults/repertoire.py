"""Selection of the shipped tasks in which a robot is tested."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import backend_class
from handcart.files.errors import FileError
from handcart.files.yaml.yaml_document import read_document
from handcart.networks.task.preparing import check
from handcart.networks.task.task_file import Task, load_task
from handcart.tasks.domain import domains

from .rehearsal import DRIVE_MAP, EXPLORE_TASK, LOCATE_TASK


def declared() -> dict[Path, Mapping[str, str]]:
    """Return the task files that the conformance kit runs, each with its settings by parameter.

    They are the tasks that each domain (a kind of work) names for the kit, and three driving tasks.
    """
    every = {path: settings for domain in domains() for path, settings in domain.rehearsals.items()}
    return {**every, DRIVE_MAP: {}, LOCATE_TASK: {}, EXPLORE_TASK: {}}


def repertoire(robot: str, settings: Mapping[str, str], backend: str) -> tuple[Path, ...]:
    """Return the shipped tasks for testing a robot on a backend.

    These are the tasks that name the robot or one of its variants. If there are none, they are all tasks that
    the robot can do. Tasks whose worlds the backend cannot simulate are omitted.

    Args:
        robot: name of a shipped robot, or path of a robot's file.
        settings: settings that select this robot in any task.
        backend: name of the backend.

    Raises:
        FileError: the robot's file is invalid.
    """
    return tuple(path for path in _fitting(robot, settings, backend) if not lacking(path, backend))


def left_out(robot: str, settings: Mapping[str, str], backend: str) -> dict[Path, tuple[str, ...]]:
    """Return the tasks that suit a robot but not the backend, with the keys of the tasks' world files that
    the backend does not simulate.

    `repertoire` omits these tasks.
    """
    found = {path: lacking(path, backend) for path in _fitting(robot, settings, backend)}
    return {path: keys for path, keys in found.items() if keys}


def lacking(path: Path, backend: str) -> tuple[str, ...]:
    """Return the keys of a task's world that a backend does not simulate, sorted; empty if it lacks none."""
    keys = backend_class(backend).lacks
    world = load_task(path).path("world") if keys else None
    return () if world is None else tuple(sorted(keys & set(read_document(world).data)))


def _fitting(robot: str, settings: Mapping[str, str], backend: str) -> tuple[Path, ...]:
    load_robot(robot)
    own = tuple(path for path in declared() if _made_for(load_task(path), robot))
    return own or tuple(path for path in declared() if _possible(path, settings, backend))


def _made_for(task: Task, robot: str) -> bool:
    by_path = robot.endswith((".yaml", ".yml"))
    return not by_path and task.robot.partition("/")[0] == robot.partition("/")[0]


def _possible(path: Path, settings: Mapping[str, str], backend: str) -> bool:
    """Return whether the robot has the parts that the task's primitives need, and reaches its places."""
    try:
        return not check(path, backend, settings).errors
    except FileError:
        return False
