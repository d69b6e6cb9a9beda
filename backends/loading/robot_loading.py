"""Robots by their names or files, read and held against their URDFs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.robot_findings import robot_findings
from handcart.backends.description.robot_names import robot_path
from handcart.backends.description.sensor_spec import UnreadableFile
from handcart.files.errors import FileError, Finding
from handcart.files.models.loading import Loaded, load_document
from handcart.files.yaml.yaml_document import Document, read_document

from .robot_model import model_for

RENAMED_KEYS = {"localiser": "localizer"}
"""Renamed keys of a robot's file, by their former names."""


def load_robot(name: str, drives: bool = True) -> RobotFile:
    """Load a robot by its name, or by the path of its YAML file.

    Args:
        name: name or path.
        drives: True to check the contents of the sections `can` and `ros2` as well, against the robot and its
            EDS files.

    Raises:
        FileError: the file or its URDF is missing or invalid.
    """
    path = robot_path(name)
    document, warnings = _with_new_keys(read_document(path))
    loaded = load_document(document, model_for(document))
    robot = _with_files(loaded, path.parent).read_in(path.parent, warnings)
    findings = robot_findings(robot, loaded.document, drives)
    if findings:
        raise FileError(findings)
    return robot.without_errors() if robot.errors.none else robot


def _with_files(loaded: Loaded[RobotFile], folder: Path) -> RobotFile:
    """Return the robot with the content of the files that its sensors' sections name."""
    robot, changed = loaded.value, {}
    for name, spec in robot.sensors.items():
        try:
            read = spec.with_files(folder)
        except UnreadableFile as wrong:
            raise loaded.refuse((*robot.key_of(name), wrong.key), str(wrong)) from None
        if read is not spec:
            changed[name] = read
    return robot.with_sensors(changed) if changed else robot


def _with_new_keys(document: Document) -> tuple[Document, tuple[str, ...]]:
    """Return a robot's file with renamed keys under their new names, and a warning for each."""
    content, warnings = document.root.content, []
    if not isinstance(content, dict):
        return document, ()
    for old, new in RENAMED_KEYS.items():
        if old in content and new not in content:
            key, words = content[old], f"the key is called {new!r} now; {old!r} is still read"
            warnings.append(str(Finding(document.file, key.key_line, key.key_column, words)))
            content = {new if name == old else name: item for name, item in content.items()}
    return replace(document, root=replace(document.root, content=content)), tuple(warnings)
