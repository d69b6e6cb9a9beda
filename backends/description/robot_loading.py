"""Robots by their names or files, read and held against their URDFs."""

from __future__ import annotations

from dataclasses import replace

from handcart.files.errors import FileError, Finding
from handcart.files.models.loading import load_document
from handcart.files.yaml.yaml_document import Document, read_document

from .robot_file import RobotFile
from .robot_findings import robot_findings
from .robot_names import robot_path

RENAMED = {"localiser": "localizer"}
"""Keys of a robot's file, by what they were called before."""


def load_robot(name: str, drives: bool = True) -> RobotFile:
    """Load a robot by its name, or by the path of its YAML file.

    Args:
        name: or path.
        drives: whether its section `can` is checked whole: for who drives by CAN, and who only looks.

    Raises:
        FileError: the file or its URDF is missing, or something in them is wrong.
    """
    path = robot_path(name)
    document, warnings = _with_new_keys(read_document(path))
    loaded = load_document(document, RobotFile)
    robot = loaded.value.read_in(path.parent, warnings)
    findings = robot_findings(robot, loaded.document, drives)
    if findings:
        raise FileError(findings)
    return robot.without_errors() if robot.errors.none else robot


def _with_new_keys(document: Document) -> tuple[Document, tuple[str, ...]]:
    """A robot's file with the keys that are called otherwise now, and a warning of each."""
    content, warnings = document.root.content, []
    if not isinstance(content, dict):
        return document, ()
    for old, new in RENAMED.items():
        if old in content and new not in content:
            key, words = content[old], f"the key is called {new!r} now; {old!r} is still read"
            warnings.append(str(Finding(document.file, key.key_line, key.key_column, words)))
            content = {new if name == old else name: each for name, each in content.items()}
    return replace(document, root=replace(document.root, content=content)), tuple(warnings)
