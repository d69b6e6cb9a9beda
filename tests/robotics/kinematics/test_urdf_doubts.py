"""Limits that look like degrees or millimetres, and followers that are driven beyond their limits."""

from __future__ import annotations

import pytest

from handcart.robotics.kinematics.urdf_faults import urdf_faults

URDF = """\
<robot name="r"><link name="a"/><link name="b"/><link name="c"/>
<joint name="j1" type="{kind}"><parent link="a"/><child link="b"/>
  <limit lower="{low}" upper="{high}" effort="1" velocity="1"/></joint>
<joint name="j2" type="revolute"><parent link="a"/><child link="c"/>
  <limit lower="-0.5" upper="0.5" effort="1" velocity="1"/>{mimic}</joint>
</robot>
"""


def doubts(kind: str, low: float, high: float, mimic: str = "") -> list[str]:
    """Return the remarks on such a URDF, which is usable nevertheless."""
    found = urdf_faults(URDF.format(kind=kind, low=low, high=high, mimic=mimic))
    assert all(fault.mild for fault in found)
    return [f"{fault.line}: {fault.message}" for fault in found]


@pytest.mark.parametrize(
    ("kind", "low", "high", "words"),
    [
        ("revolute", -180.0, 180.0, "3: joint 'j1': its limits are -180 to 180 rad, more than two turns"),
        ("revolute", -12.566371, 12.566371, ""),
        ("revolute", 0.0, 12.6, "more than two turns"),
        ("prismatic", 0.0, 386.0, "3: joint 'j1': its limits are 0 to 386 m; mm? needed: metres"),
        ("prismatic", 0.0, 15.0, ""),
        ("continuous", -180.0, 180.0, ""),
    ],
)  # fmt: skip
def test_limits_in_another_unit_are_told(kind: str, low: float, high: float, words: str) -> None:
    found = doubts(kind, low, high)
    assert bool(found) is bool(words)
    assert words in "".join(found)


@pytest.mark.parametrize(
    ("kind", "mimic", "words"),
    [
        ("revolute", '<mimic joint="j1"/>', "'j1' drives it from -0.2 to 0.8 rad; allowed: its own limits"),
        ("revolute", '<mimic joint="j1" multiplier="0.5"/>', ""),
        ("revolute", '<mimic joint="j1" multiplier="0.5" offset="0.2"/>', "from 0.1 to 0.6 rad"),
        ("revolute", '<mimic joint="j1" multiplier="-0.6"/>', ""),
        ("revolute", '<mimic joint="j1" multiplier="-1"/>', "from -0.8 to 0.2 rad"),
        ("prismatic", '<mimic joint="j1" multiplier="2"/>', "from -0.4 to 1.6 rad"),
        ("continuous", '<mimic joint="j1" multiplier="9"/>', ""),
    ],
)  # fmt: skip
def test_follower_driven_beyond_its_limits_is_told(kind: str, mimic: str, words: str) -> None:
    found = doubts(kind, -0.2, 0.8, mimic)
    assert len(found) == bool(words)
    assert words in "".join(found)
    assert all(text.startswith("5: joint 'j2': ") for text in found)


def test_follower_of_a_follower_is_driven_by_the_first() -> None:
    """j2 = 2 (0.5 j1 + 0.2) - 0.1, that is j1 + 0.3."""
    middle = (
        '<link name="d"/><joint name="j0" type="revolute"><parent link="a"/><child link="d"/>'
        '<limit lower="-9" upper="9" effort="1" velocity="1"/>'
        '<mimic joint="j1" multiplier="0.5" offset="0.2"/></joint>'
    )  # fmt: skip
    text = URDF.format(
        kind="revolute", low=-0.2, high=0.8, mimic='<mimic joint="j0" multiplier="2" offset="-0.1"/>'
    )
    (found,) = urdf_faults(text.replace("</robot>", f"{middle}</robot>"))
    assert "'j0' drives it from 0.1 to 1.1 rad" in found.message


@pytest.mark.parametrize("kind", ["revolute", "continuous"])
@pytest.mark.parametrize("key", ["effort", "velocity"])
def test_negative_effort_or_speed_is_told(kind: str, key: str) -> None:
    """Some makers write -1 for a limit that they do not know."""
    text = URDF.format(kind=kind, low=-1, high=1, mimic="").replace(f'{key}="1"', f'{key}="-1"', 1)
    (fault,) = urdf_faults(text)
    assert fault.mild
    assert fault.message == f"joint 'j1': its {key} limit is -1 and counts as none; allowed: 0 or more"


@pytest.mark.parametrize("kind", ["floating", "planar"])
def test_joint_that_no_drive_moves_is_told(kind: str) -> None:
    (told,) = doubts(kind, 0, 0)
    assert told.startswith(f"2: joint 'j1': a {kind} joint is not driven: what it carries is taken as fixed")
