"""A robot whose meshes are COLLADA in millimetres and inches, and whose wheels state no effort."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np

CUBE = np.array(list(product((-0.5, 0.5), repeat=3)))
FACES = (
    0,
    1,
    3,
    0,
    3,
    2,
    4,
    6,
    7,
    4,
    7,
    5,
    0,
    4,
    5,
    0,
    5,
    1,
    2,
    3,
    7,
    2,
    7,
    6,
    0,
    2,
    6,
    0,
    6,
    4,
    1,
    5,
    7,
    1,
    7,
    3,
)
COLLADA = """\
<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2026-01-01T00:00:00</created><modified>2026-01-01T00:00:00</modified>{unit}
<up_axis>Y_UP</up_axis></asset><library_geometries><geometry id="g" name="g"><mesh><source id="p">
<float_array id="pa" count="24">{corners}</float_array><technique_common>
<accessor source="#pa" count="8" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="12">
<input semantic="VERTEX" source="#v" offset="0"/><p>{faces}</p></triangles></mesh></geometry>
</library_geometries><library_visual_scenes><visual_scene id="s"><node id="n" name="n">
<instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>
"""
ROBOT = """\
format: handcart-robot/1
urdf: robot.urdf
links: {base: foot}
drive: {left: l, right: r, wheel_radius_m: 0.1, tread_m: 0.5, top_speed_m_s: 0.5,
        top_turn_deg_s: 60, acceleration_m_s2: 0.5, turn_acceleration_deg_s2: 90}
period_s: 0.05
footprint_radius_m: 0.4
localizer: odometry
errors: {none: true}
tolerance: {base_mm: 25, base_deg: 1.5, joints_deg: 0.3, gripper_mm: 1, object_mm: 8}
"""
MASS = (
    '<inertial><mass value="{0}"/><inertia ixx="{1}" iyy="{1}" izz="{1}" ixy="0" ixz="0" iyz="0"/></inertial>'
)
MESH = '<collision><origin xyz="0 0 {0}"/><geometry><mesh filename="{1}"/></geometry></collision>'
SIDE = """\
<link name="{0}_rim">{mass}<collision><geometry><mesh filename="wheel.dae"/></geometry></collision></link>
<joint name="{0}" type="continuous"><parent link="body"/><child link="{0}_rim"/><origin xyz="0 {1} 0.1"/>
<axis xyz="0 1 0"/><dynamics damping="20" friction="10"/></joint>
"""
BALL = """\
<link name="caster_{0}">{mass}<collision><geometry><sphere radius="0.04"/></geometry></collision></link>
<joint name="caster_{0}" type="fixed"><parent link="body"/><child link="caster_{0}"/>
<origin xyz="{0} 0 0.04"/></joint>
"""


def write_collada(path: Path, size: tuple[float, float, float], metres: float | None = None) -> None:
    """Write a box of a size in [m], with its corners in a unit of so many metres."""
    unit = "" if metres is None else f'<unit meter="{metres}" name="unit"/>'
    corners = (CUBE * size / (metres or 1.0)).ravel()
    words = {"corners": " ".join(map(str, corners)), "faces": " ".join(map(str, FACES))}
    path.write_text(COLLADA.format(unit=unit, **words), encoding="utf-8")


def write_robot(folder: Path) -> Path:
    """Write the robot's files, its body reaching down to the floor; return the robot's file."""
    write_collada(folder / "body.dae", (0.4, 0.3, 0.2), 0.001)
    write_collada(folder / "wheel.dae", (0.2, 0.05, 0.2), 0.0254)
    light = MASS.format(0.5, 0.002)
    text = f'<robot name="r"><link name="foot"/><link name="body">{MASS.format(20, 0.5)}'
    text += MESH.format(0.1, "body.dae") + "</link>"
    text += '<joint name="on" type="fixed"><parent link="foot"/><child link="body"/></joint>'
    text += SIDE.format("l", 0.25, mass=light) + SIDE.format("r", -0.25, mass=light)
    text += BALL.format(0.15, mass=light) + BALL.format(-0.15, mass=light)
    (folder / "robot.urdf").write_text(text + "</robot>", encoding="utf-8")
    (folder / "robot.yaml").write_text(ROBOT, encoding="utf-8")
    return folder / "robot.yaml"
