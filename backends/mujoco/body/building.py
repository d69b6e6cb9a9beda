"""Building the model of a robot alone, to find out what MuJoCo refuses."""

from __future__ import annotations

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.physics.refusal import refusal
from handcart.backends.physics.urdf.sound_urdf import sound_urdf
from handcart.files.errors import InputError

from .mujoco_urdf import read_robot

ENGINE_NAME = "MuJoCo"


def model_refusal(robot: RobotFile) -> InputError | None:
    """Try to build MuJoCo's model of a robot; return the error if that fails, otherwise None.

    Raises:
        MissingMuJoCo: MuJoCo isn't installed.
    """
    try:
        read_robot(sound_urdf(robot)).compile()
    except InputError as error:
        return error
    except ValueError as error:
        return refusal(ENGINE_NAME, error, robot.whole)
    return None
