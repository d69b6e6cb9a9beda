"""Packages that `package://` names: of Python, of ROS 1 and 2, and those that bring data alone."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from handcart.backends.urdf.mesh_path import mesh_path
from handcart.backends.urdf.packages import package_folders, package_of
from handcart.backends.urdf.robot_parts import UrdfError, read_part

URDF = '<robot name="r"><link name="base"/></robot>'


def package(folder: Path, marked: bool = False) -> Path:
    """A package with a URDF and a mesh in it."""
    (folder / "meshes").mkdir(parents=True)
    (folder / "r.urdf").write_text(URDF, encoding="utf-8")
    (folder / "meshes" / "a b.stl").write_text("solid", encoding="utf-8")
    if marked:
        (folder / "package.xml").write_text("<package/>", encoding="utf-8")
    return folder


@pytest.mark.parametrize(
    ("where", "variable", "entry"),
    [
        ("install/share/rob-ot_1", "AMENT_PREFIX_PATH", "install"),
        ("src/robots/rob-ot_1", "ROS_PACKAGE_PATH", "src"),
        ("src/rob-ot_1", "ROS_PACKAGE_PATH", "src/rob-ot_1"),
        ("data/robots/rob-ot_1", "ROS_PACKAGE_PATH", "data/robots"),
        ("site/share/rob-ot_1", "", "site"),
        ("site/cmeel.prefix/share/rob-ot_1", "", "site"),
    ],
)
def test_package_is_found_with_its_meshes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, where: str, variable: str, entry: str
) -> None:
    folder = package(tmp_path / where, marked=where.startswith("src"))
    if variable:
        monkeypatch.setenv(variable, os.pathsep.join(("/no/such", str(tmp_path / entry))))
    else:
        monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path / entry)])
    assert list(package_folders("rob-ot_1")) == [folder]
    assert package_of(folder / "r.urdf") == "package://rob-ot_1/r.urdf"
    assert read_part("package://rob-ot_1/r.urdf", tmp_path).file == str(folder / "r.urdf")
    elsewhere = tmp_path / "mine" / "r.urdf"
    name = "package://rob-ot_1/meshes/a%20b.stl"
    assert mesh_path(name, elsewhere, elsewhere.parent) == folder / "meshes" / "a b.stl"


def test_package_of_python_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = package(tmp_path / "some_robot")
    (folder / "__init__.py").write_text("", encoding="utf-8")
    monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path)])
    assert package_of(folder / "r.urdf") == "package://some_robot/r.urdf"
    (tmp_path / "lone.urdf").write_text(URDF, encoding="utf-8")
    assert package_of(tmp_path / "lone.urdf") is None


def test_links_of_a_workspace_are_followed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The links are those of `colcon build --symlink-install`."""
    source = package(tmp_path / "src" / "robot")
    (tmp_path / "install" / "share" / "robot").mkdir(parents=True)
    (tmp_path / "install" / "share" / "robot" / "r.urdf").symlink_to(source / "r.urdf")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "install"))
    assert read_part("package://robot/r.urdf", tmp_path).places


@pytest.mark.parametrize(
    "urdf", ["package://robot/../r.urdf", "package://robot//etc/passwd", "package://x/r.urdf"]
)
def test_what_is_not_in_a_package_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, urdf: str
) -> None:
    package(tmp_path / "share" / "robot")
    (tmp_path / "share" / "r.urdf").write_text(URDF, encoding="utf-8")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    with pytest.raises(ValueError, match=r"leads out|is absolute|missing package 'x'"):
        read_part(urdf, tmp_path)
    assert issubclass(UrdfError, ValueError)
