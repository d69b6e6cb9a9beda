"""URDFs as strangers write them: what they hold and which files they name (rows T1 to T4, T9, T13)."""

import os
from pathlib import Path

import pytest

from handcart.backends.description.robot_names import robot_path
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.urdf.mesh_path import is_mesh, mesh_path
from handcart.backends.urdf.robot_parts import read_urdf_file
from handcart.files.errors import FileError, UnsafePath

LINK = "<robot name='r'>\n<link name='a'>\n<inertial>{}</inertial></link></robot>"


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    """The file of a robot of one's own: the librarian's, copied."""
    source = robot_path("librarian")
    for path in source.parent.glob("librarian.urdf"):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    (tmp_path / "robot.yaml").write_bytes(source.read_bytes())
    return tmp_path / "robot.yaml"


def error_of(robot: Path) -> str:
    with pytest.raises(FileError) as error:
        load_robot(str(robot))
    return str(error.value)


@pytest.mark.parametrize(
    ("part", "words"),
    [
        ("<origin xyz='0 nan 0'/>", "origin xyz is '0 nan 0'; allowed: 3 finite numbers"),
        ("<origin rpy='0 0 inf'/>", "origin rpy is '0 0 inf'"),
        ("<origin xyz='0 0'/>", "origin xyz is '0 0'"),
        ("<mass value='1e309'/>", "mass value is '1e309'; allowed: a finite number"),
        ("<mass value='1_0'/>", "mass value is '1_0'"),
        ("<mass value=''/>", "mass value is ''"),
        ("<inertia ixx='${mass}'/>", "inertia ixx is '${mass}', an expression of xacro"),
        ("<mass value='1e200'/>", "mass value is '1e200'"),
    ],
)
def test_what_should_be_a_number_is_told_with_its_line_and_link(
    tmp_path: Path, part: str, words: str
) -> None:
    """T9"""
    (tmp_path / "r.urdf").write_text(LINK.format(part), encoding="utf-8")
    with pytest.raises(FileError) as error:
        read_urdf_file(tmp_path / "r.urdf")
    assert f"{tmp_path}/r.urdf:3:11: link 'a': {words}" in str(error.value)


def test_another_root_is_told(tmp_path: Path) -> None:
    (tmp_path / "r.sdf").write_text("<sdf/>", encoding="utf-8")
    with pytest.raises(FileError, match=r"r.sdf:1:1: the URDF's root is <sdf>; allowed: <robot>"):
        read_urdf_file(tmp_path / "r.sdf")


def test_a_robot_whose_urdf_is_a_pipe_is_refused(robot: Path) -> None:
    """T1: it doesn't wait for a writer."""
    (robot.parent / "librarian.urdf").unlink()
    os.mkfifo(robot.parent / "librarian.urdf")
    assert "robot.yaml:" in error_of(robot)
    assert "missing text file 'librarian.urdf'" in error_of(robot)


def test_a_huge_urdf_is_not_read(robot: Path) -> None:
    """T2"""
    os.truncate(robot.parent / "librarian.urdf", 10**9)
    assert "librarian.urdf:1:1: the file has 1000000000 bytes; allowed: at most" in error_of(robot)


def test_entities_are_refused(robot: Path) -> None:
    """T3"""
    urdf = robot.parent / "librarian.urdf"
    text = urdf.read_text(encoding="utf-8")
    bomb = '<!DOCTYPE robot [<!ENTITY a "aaaa">]>'
    urdf.write_text(text.replace("<robot", bomb + "<robot", 1), encoding="utf-8")
    assert "a document type (DOCTYPE)" in error_of(robot)


@pytest.fixture
def shop(tmp_path: Path) -> Path:
    """robot/urdf/r.urdf beside robot/meshes/m.stl, and a mesh that lies outside."""
    for folder in ("robot/urdf", "robot/meshes", "shared/meshes"):
        (tmp_path / folder).mkdir(parents=True)
    for mesh in ("robot/meshes/m.stl", "shared/meshes/n.stl", "secret.stl"):
        (tmp_path / mesh).touch()
    (tmp_path / "robot" / "link.stl").symlink_to("../secret.stl")
    return tmp_path / "robot" / "urdf" / "r.urdf"


@pytest.mark.parametrize(
    ("name", "found"),
    [
        ("../meshes/m.stl", "robot/meshes/m.stl"),
        ("package://robot/meshes/m.stl", "robot/meshes/m.stl"),
        ("model://shared/meshes/n.stl", "shared/meshes/n.stl"),
        ("package://robot/urdf/../meshes/m.stl", "robot/meshes/m.stl"),
    ],
)
def test_meshes_are_found(shop: Path, name: str, found: str) -> None:
    base = shop.parents[2]
    assert mesh_path(name, shop, base / "robot").resolve() == base / found


def test_an_absolute_path_is_taken_as_it_stands(shop: Path) -> None:
    mesh = shop.parents[2] / "secret.stl"
    assert mesh_path(str(mesh), shop, shop.parent) == mesh
    assert mesh_path(f"file://{mesh}", shop, shop.parent) == mesh


@pytest.mark.parametrize(
    "name",
    [
        "../../secret.stl",
        "../link.stl",
        "../meshes/../../secret.stl",
        "package://robot/../secret.stl",
        "package://../secret.stl",
        "package://robot/../../../../../etc/passwd",
        "package://",
        "package://robot",
        "",
        "~/m.stl",
        "..\\m.stl",
        "m\0.stl",
    ],
)
def test_meshes_elsewhere_are_refused(shop: Path, name: str) -> None:
    """T13"""
    with pytest.raises(UnsafePath):
        mesh_path(name, shop, shop.parent.parent)


def test_a_ros_package_holds_its_meshes(shop: Path) -> None:
    """Also where the robot's file lies deeper in it."""
    with pytest.raises(UnsafePath):
        mesh_path("../meshes/m.stl", shop, shop.parent)
    (shop.parent.parent / "package.xml").touch()
    assert mesh_path("../meshes/m.stl", shop, shop.parent).is_file()


def test_a_mesh_that_leads_out_is_told_at_its_link(robot: Path) -> None:
    """T13"""
    urdf = robot.parent / "librarian.urdf"
    text = urdf.read_text(encoding="utf-8")
    mesh = (
        '<link name="x"><visual><geometry><mesh filename="../../x.stl"/></geometry></visual></link>\n'
        '<joint name="on_x" type="fixed"><parent link="base"/><child link="x"/></joint></robot>'
    )
    urdf.write_text(text.replace("</robot>", mesh), encoding="utf-8")
    assert "link 'x': mesh '../../x.stl': the path '../../x.stl' leads out of" in error_of(robot)


def test_only_regular_files_are_meshes(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.stl")
    (tmp_path / "huge.stl").touch()
    os.truncate(tmp_path / "huge.stl", 10**12)
    (tmp_path / "m.stl").touch()
    assert [is_mesh(tmp_path / f"{name}.stl") for name in ("pipe", "huge", "none", "m")] == [0, 0, 0, 1]
