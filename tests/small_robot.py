"""Robot files of a base without sensors, and of one with a lift and a turning joint; URDFs are the tests'."""

BASE_ROBOT = """\
format: handcart-robot/1
urdf: robot.urdf
period_s: 0.05
footprint_radius_m: 0.3
localizer: odometry
drive: {wheel_radius_m: 0.1, tread_m: 0.5, top_speed_m_s: 0.5, top_turn_deg_s: 90, acceleration_m_s2: 0.5,
        turn_acceleration_deg_s2: 90}
"""
TOLERANCE = (
    "tolerance: {base_mm: 25, base_deg: 1.5, joints_deg: 0.3, slides_mm: 3, gripper_mm: 1, object_mm: 8}\n"
)
SMALL_ROBOT = BASE_ROBOT + TOLERANCE
LIFTING_ROBOT = f"""\
{BASE_ROBOT}arm: {{joints: [lift, turn], top_speed_deg_s: 90, acceleration_deg_s2: 180, slide_speed_mm_s: 50,
      slide_acceleration_mm_s2: 100, postures: {{home: [200, 0]}}}}
{TOLERANCE}"""
