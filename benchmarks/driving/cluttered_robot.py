"""The robot of `cluttered` and `doors`: a disc or a box on two wheels with a lidar."""

from __future__ import annotations

from pathlib import Path

URDF_TEMPLATE = """\
<?xml version="1.0"?>
<robot name="disc">
  <link name="base">
    <inertial>
      <origin xyz="0 0 0.15"/><mass value="20"/>
      <inertia ixx="0.36" ixy="0" ixz="0" iyy="0.36" iyz="0" izz="0.44"/>
    </inertial>
    <collision>
      <origin xyz="0 0 0.12"/><geometry>{body}</geometry>
    </collision>
    <visual><origin xyz="0 0 0.12"/><geometry>{body}</geometry></visual>
  </link>
  <link name="range_sensor"/>
  <joint name="range_sensor_mount" type="fixed">
    <parent link="base"/><child link="range_sensor"/><origin xyz="0 0 0.25"/>
  </joint>
{wheels}{casters}</robot>
"""
WHEEL_TEMPLATE = """\
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
CASTER_TEMPLATE = """\
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
ROBOT_TEMPLATE = """\
format: handcart-robot/1
urdf: robot.urdf
period_s: 0.05
footprint: {footprint}
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


def write_robot(
    folder: Path, sides: tuple[float, ...], speed: float, localizer: str, view: float = 360.0
) -> Path:
    """Write the robot's file and its URDF; return the path of the file.

    Args:
        folder: existing folder for the files.
        sides: radius of a disc, or length and width of a rectangle, in [m]; the body is 1 cm smaller at each
            side.
        speed: top speed in [m/s]; its acceleration in [m/s²] is as large.
        localizer: as in a robot's file.
        view: angle that the lidar sees, in [deg]; a beam a degree.
    """
    half = [sides[0], sides[0]] if len(sides) == 1 else [0.5 * side for side in sides]
    tread = half[1] - 0.05
    body = f'<cylinder radius="{half[0] - 0.01:g}" length="0.16"/>'
    if len(sides) > 1:
        body = f'<box size="{sides[0] - 0.02:g} {sides[1] - 0.02:g} 0.16"/>'
    wheels = "".join(
        WHEEL_TEMPLATE.format(side=side, y=y) for side, y in (("left", tread), ("right", -tread))
    )
    ends = (("front", half[0] - 0.05), ("rear", 0.05 - half[0]))
    casters = "".join(CASTER_TEMPLATE.format(end=end, x=x) for end, x in ends)
    (folder / "robot.urdf").write_text(URDF_TEMPLATE.format(body=body, wheels=wheels, casters=casters))
    path = folder / "robot.yaml"
    footprint = (
        f"{{radius_m: {sides[0]}}}" if len(sides) == 1 else f"{{rectangle_m: [{sides[0]}, {sides[1]}]}}"
    )
    lidar = {"beams": round(view) + (view < 360.0), "start_deg": -view / 2, "end_deg": view / 2}
    drive = {"tread": 2.0 * tread, "speed": speed, "acceleration": speed}
    path.write_text(ROBOT_TEMPLATE.format(footprint=footprint, localizer=localizer, **drive, **lidar))
    return path
