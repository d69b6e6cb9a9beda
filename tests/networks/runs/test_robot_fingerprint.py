"""The checksum by which `resume` knows the robot again."""

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.loading.robot_loading import load_robot
from handcart.networks.runs.run_header import robot_fingerprint


class LaterRobotFile(RobotFile):
    """A robot's file of a later version, with one more key."""

    added_mm: float = 3.0


def test_a_key_with_its_default_changes_no_robot() -> None:
    spec = load_robot("cart")
    later = LaterRobotFile.model_construct(spec.model_fields_set, **dict(spec))
    assert robot_fingerprint(later) == robot_fingerprint(spec)


def test_a_changed_value_is_another_robot() -> None:
    spec = load_robot("cart")
    slower = spec.model_copy(update={"drive": spec.drive.model_copy(update={"top_speed_m_s": 0.123})})
    assert robot_fingerprint(slower) != robot_fingerprint(spec)
