"""The robot of `cluttered`: a disc on two wheels with a lidar, written beside a world."""

from __future__ import annotations

from pathlib import Path

URDF = """\
<?xml version="1.0"?>
<robot name="disc">
  <link name="base">
    <inertial>
      <origin xyz="0 0 0.15"/><mass value="20"/>
      <inertia ixx="0.36" ixy="0" ixz="0" iyy="0.36" iyz="0" izz="0.44"/>
    </inertial>
    <collision>
      <origin xyz="0 0 0.12"/><geometry><cylinder radius="{body}" length="0.16"/></geometry>
    </collision>
    <visual><origin xyz="0 0 0.12"/><geometry><cylinder radius="{body}" length="0.16"/></geometry></visual>
  </link>
  <link name="range_sensor"/>
  <joint name="range_sensor_mount" type="fixed">
    <parent link="base"/><child link="range_sensor"/><origin xyz="0 0 0.25"/>
  </joint>
{wheels}{casters}</robot>
"""
WHEEL = """\
  <link name="{side}_wheel">
    <inertial>
      <mass value="1"/><inertia ixx="0.0027" ixy="0" ixz="0" iyy="0.005" iyz="0" izz="0.0027"/>
    </inertial>
    <collision>
      <origin rpy="1.570796327 0 0"/><geometry><cylinder radius="0.1" length="0.04"/></geometry>
    </collision>
  </link>
  <joint name="{side}_wheel" type="continuous">
    <parent link="base"/><child link="{side}_wheel"/><origin xyz="0 {y} 0.1"/><axis xyz="0 1 0"/>
    <limit effort="20" velocity="40"/><dynamics damping="0.05" friction="0.025"/>
  </joint>
"""
CASTER = """\
  <link name="{end}_caster">
    <inertial>
      <mass value="0.3"/><inertia ixx="0.0001" ixy="0" ixz="0" iyy="0.0001" iyz="0" izz="0.0001"/>
    </inertial>
    <collision><geometry><sphere radius="0.03"/></geometry></collision>
  </link>
  <joint name="{end}_caster_mount" type="fixed">
    <parent link="base"/><child link="{end}_caster"/><origin xyz="{x} 0 0.03"/>
  </joint>
"""
ROBOT = """\
format: handcart-robot/1
urdf: robot.urdf
period_s: 0.05
footprint_radius_m: {radius}
localizer: {localizer}
drive:
  wheel_radius_m: 0.1
  tread_m: {tread}
  top_speed_m_s: {speed}
  top_turn_deg_s: 120
  acceleration_m_s2: {acceleration}
  turn_acceleration_deg_s2: 360
range_sensor:
  {{beams: {beams}, reach_m: 12.0, sigma_mm: 10, start_deg: {start_deg}, end_deg: {end_deg}}}
errors:
  wheel_radius_percent: 0.2
  tread_percent: 0.5
  slip_percent: 1.0
  start_mm: 20.0
  start_deg: 1.0
tolerance: {{base_mm: 25, base_deg: 1.5, joints_deg: 0.3, gripper_mm: 1, object_mm: 8}}
"""


def write_robot(folder: Path, radius: float, speed: float, localizer: str, view: float = 360.0) -> Path:
    """Write the robot's file and its URDF; return the path of the file.

    Args:
        folder: existing folder for the files.
        radius: radius of the footprint, in [m]; the body is 1 cm smaller.
        speed: top speed in [m/s]; its acceleration in [m/s²] is as large.
        localizer: as in a robot's file.
        view: angle that the lidar sees, in [deg]; a beam a degree.
    """
    tread = radius - 0.05
    wheels = "".join(WHEEL.format(side=side, y=y) for side, y in (("left", tread), ("right", -tread)))
    casters = "".join(CASTER.format(end=end, x=x) for end, x in (("front", tread), ("rear", -tread)))
    (folder / "robot.urdf").write_text(URDF.format(body=radius - 0.01, wheels=wheels, casters=casters))
    path = folder / "robot.yaml"
    lidar = {"beams": round(view) + (view < 360.0), "start_deg": -view / 2, "end_deg": view / 2}
    drive = {"tread": 2.0 * tread, "speed": speed, "acceleration": speed}
    path.write_text(ROBOT.format(radius=radius, localizer=localizer, **drive, **lidar))
    return path
