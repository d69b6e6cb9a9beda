"""What `handcart check` finds out by building engines, and about the sizes of meshes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from tests.backends.physics.mesh_robot import write_robot
from tests.tools.conftest import Said

SPECK = """\
<link name="speck"><inertial><mass value="1e-20"/>
<inertia ixx="1e-30" iyy="1e-30" izz="1e-30" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="spin" type="continuous"><parent link="body"/><child link="speck"/><axis xyz="0 0 1"/></joint>
</robot>
"""


def test_engine_names_the_line_of_the_link_that_it_refuses(
    handcart: Callable[..., Said], tmp_path: Path
) -> None:
    """`check` finds what a run would end with; `--backend` makes it a fault."""
    file = write_robot(tmp_path)
    urdf = tmp_path / "robot.urdf"
    urdf.write_text(urdf.read_text().replace("</robot>", "\n" + SPECK), encoding="utf-8")
    line = 1 + urdf.read_text().split('<link name="speck"')[0].count("\n")
    words = f"robot.urdf:{line}:1: link 'speck': MuJoCo refuses the robot: "
    said = handcart("check", file)
    assert (said.status, words in said.out) == (0, True)
    said = handcart("check", file, "--backend", "mujoco")
    assert (said.status, words in said.err) == (2, True)
    assert handcart("check", file, "--backend", "kinematic").status == 0


def test_bodies_of_many_metres_and_large_meshes_are_named(
    handcart: Callable[..., Said], tmp_path: Path
) -> None:
    file = write_robot(tmp_path)
    mesh = tmp_path / "body.dae"
    text = mesh.read_text().replace('meter="0.001"', 'meter="1"')
    mesh.write_text(text + "<!-- " + 11_000_000 * "x" + " -->", encoding="utf-8")
    said = handcart("check", file, "--all")
    assert "link 'body': a body is 400 m long; expected: up to 5 m; if it is in mm: scale=" in said.out
    assert "link 'body': collision mesh 'body.dae' has 11 MB: it is slow to load" in said.out
