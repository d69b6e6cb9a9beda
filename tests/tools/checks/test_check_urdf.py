"""`handcart check` on makers' URDFs, as they are, drafted as robots, and broken."""

from __future__ import annotations

import json
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import pytest

from benchmarks.damage.mutated_urdfs import mutated
from benchmarks.hostile.makers_urdfs import _checked
from tests.tools.conftest import Said

ROOT = Path(__file__).resolve().parents[3]
ROBOTS = ROOT / "backends" / "robots"
SEAM = ROOT / "tasks" / "track_seam" / "seam.csv"
BOX = '<collision><geometry><box size="0.3 0.3 0.3"/></geometry></collision>'
LIMIT = '<limit lower="{}" upper="{}" effort="5" velocity="1"/>'
CRANE = f"""\
<robot name="crane">
  <link name="base_link">{BOX}</link><link name="mast">{BOX}</link><link name="boom">{BOX}</link>
  <link name="hook"/>
  <joint name="lift" type="prismatic"><parent link="base_link"/><child link="mast"/><axis xyz="0 0 1"/>
    <limit lower="0.1" upper="0.2" effort="5" velocity="1"/></joint>
  <joint name="slew" type="revolute"><parent link="mast"/><child link="boom"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="5" velocity="1"/></joint>
  <joint name="tip" type="revolute"><parent link="boom"/><child link="hook"/><origin xyz="0.5 0 0.5"/>
    <limit lower="-1" upper="1" effort="5" velocity="1"/></joint>
</robot>
"""

DRIVE = """\
drive: {wheel_radius_m: 0.1, tread_m: 0.5, top_speed_m_s: 0.5, top_turn_deg_s: 90, acceleration_m_s2: 0.5,
        turn_acceleration_deg_s2: 90}
"""
ALLOWED = """\
allowed_contacts:     # their hulls touch however the arm is; look whether they may
  - ["base_link", "boom"]
"""


@pytest.fixture
def crane(tmp_path: Path) -> Path:
    """A lift whose third link always overlaps the first."""
    path = tmp_path / "crane.urdf"
    path.write_text(CRANE, encoding="utf-8")
    return path


@pytest.fixture
def robot(handcart: Callable[..., Said], crane: Path) -> Path:
    """Its draft."""
    path = crane.with_name("robot.yaml")
    assert handcart("check", crane, "--draft", path).status == 0
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace(ALLOWED, "") + DRIVE, encoding="utf-8")
    return path


def test_a_urdf_alone_is_told_of(handcart: Callable[..., Said], crane: Path) -> None:
    said = handcart("check", crane)
    assert said.status == 0
    for words in (
        f"{crane}:2:3: link 'base_link': no mass: an engine takes it as nearly weightless (and 2 more links",
        "lift    prismatic   100 mm    200 mm   1000 mm/s   5 N",
        "base: base_link",
        "arm: lift, slew, tip",
        "hand: hook",
        f"--draft {crane.parent / 'robot.yaml'}",
    ):
        assert words in said.out
    report = json.loads(handcart("check", crane, "--json").out)
    assert report["ok"]
    assert report["robot"]["outline"]["chains"] == [["lift", "slew", "tip"]]
    assert [joint["name"] for joint in report["robot"]["joints"]] == ["lift", "slew", "tip"]


def test_a_draft_is_not_written_over_a_file(handcart: Callable[..., Said], crane: Path, robot: Path) -> None:
    assert "is there already" in handcart("check", crane, "--draft", robot).err
    assert (
        "allowed: a file in the URDF's folder" in handcart("check", crane, "--draft", "/tmp/x/robot.yaml").err
    )
    assert f"handcart check {robot}" in handcart("check", crane).out


def test_links_that_always_touch_are_proposed_and_allowed(handcart: Callable[..., Said], robot: Path) -> None:
    report = json.loads(handcart("check", robot, "--json").out)
    assert report["robot"]["self_contact"]["always"] == [["base", "boom"]]
    assert report["robot"]["self_contact"]["free"] == 0
    assert report["robot"]["reach"] is not None
    assert any("touch however the arm stands: base with boom;" in warning for warning in report["warnings"])
    assert "  base touches boom in 100 % of postures\n" in handcart("check", robot).out
    said = handcart("check", robot, "--allow")
    assert said.status == 0
    assert "+  - [base, boom]" in said.err
    assert "allowed_contacts:\n  - [base, boom]\n" in robot.read_text(encoding="utf-8")
    after = json.loads(handcart("check", robot, "--json").out)
    assert after["robot"]["self_contact"]["free"] == 200
    assert not any("however the arm stands" in warning for warning in after["warnings"])
    assert "no pair was added" in handcart("check", robot, "--allow").err


def test_only_robots_with_trays_and_tags_are_told_of_books(
    handcart: Callable[..., Said], robot: Path
) -> None:
    report = json.loads(handcart("check", robot, "--json").out)
    assert not any("'tray'" in warning or "return_book" in warning for warning in report["warnings"])
    assert "books" not in report["robot"]
    text = robot.read_text(encoding="utf-8")
    robot.write_text(text.replace("    home:", "    look_at_tag: [150, 0, 0]\n    home:"), encoding="utf-8")
    assert "no link 'tray'" in handcart("check", robot).out


def test_no_free_posture_is_said_in_words(handcart: Callable[..., Said], crane: Path, robot: Path) -> None:
    """The two outer links touch in most postures, but not in all."""
    wide = BOX.replace("0.3 0.3 0.3", "1.2 1.2 1.2").replace(
        "<geometry>", '<origin xyz="0.4 0 0"/><geometry>'
    )
    text = crane.read_text(encoding="utf-8").replace(
        '<link name="hook"/>', f'<link name="hook">{wide}</link>'
    )
    crane.write_text(text, encoding="utf-8")
    said = handcart("check", robot)
    assert said.status == 0
    assert "random postures touch the robot itself" in said.out


def test_many_faults_are_told_in_few_lines(handcart: Callable[..., Said], crane: Path) -> None:
    links = "".join(f'<link name="l{n}"/>\n' for n in range(40))
    joints = "".join(
        f'<joint name="j{n}" type="fixd"><parent link="base_link"/><child link="l{n}"/></joint>\n'
        for n in range(40)
    )
    crane.write_text(CRANE.replace("</robot>", f"{links}{joints}</robot>"), encoding="utf-8")
    said = handcart("check", crane)
    assert said.status == 2
    (line,) = said.err.splitlines()
    assert line.startswith(f"{crane}:50:1: joint 'j0': unknown type 'fixd'; did you mean 'fixed'?")
    assert line.endswith("(and 39 more lines: 51, 52, 53, 54, ...)")
    assert len(handcart("check", crane, "--all").err.splitlines()) == 40
    assert len(json.loads(handcart("check", crane, "--json").out)["findings"]) == 40


@pytest.mark.parametrize(
    ("add", "line", "words"),
    [
        ("", "robot.yaml:", "the robot's file has no tool; needed: a section `tool`"),
        (
            "tool: {speed_m_s: 0.01, force_n: 2}\n",
            "joints",
            "joint 'lift' slides; allowed: arms whose joints",
        ),
    ],
)
def test_a_robot_that_cannot_follow_a_seam_is_told_at_its_line(
    handcart: Callable[..., Said], robot: Path, tmp_path: Path, add: str, line: str, words: str
) -> None:
    robot.write_text(robot.read_text(encoding="utf-8") + add, encoding="utf-8")
    said = handcart("place", robot, SEAM, "-o", tmp_path / "seam")
    assert said.status == 2
    assert words in said.err
    number = next((n for n, item in enumerate(robot.read_text().splitlines(), 1) if "joints:" in item), 0)
    assert f"{robot}:{number if add else 2}:" in said.err


def test_a_robot_without_an_arm_cannot_follow_a_seam(handcart: Callable[..., Said], tmp_path: Path) -> None:
    said = handcart("place", "cart", SEAM, "-o", tmp_path / "seam")
    assert said.status == 2
    assert "cart/robot.yaml:2:1: the robot's file has no arm; needed: a section `arm`" in said.err


@pytest.mark.parametrize("seed", range(8))
def test_a_broken_urdf_is_told_clearly(tmp_path: Path, seed: int) -> None:
    """The checks of `benchmarks.hostile.makers_urdfs`: statuses, places, lines, nothing on stderr."""
    text, what = mutated(CRANE, seed)
    path = tmp_path / "mutant.urdf"
    path.write_text(text, encoding="utf-8")
    seen = _checked(path, tmp_path / "robot.yaml")
    assert (seen.violations, what) == ((), what)
    assert set(seen.statuses) <= {0, 2}


def test_mutants_are_the_same_for_the_same_seed_and_of_both_kinds() -> None:
    assert mutated(CRANE, 5) == mutated(CRANE, 5)
    assert len({mutated(CRANE, seed)[0] for seed in range(12)}) > 8


@pytest.mark.skipif(find_spec("pybullet_data") is None, reason="needs PyBullet's robots")
@pytest.mark.parametrize(
    ("name", "status", "words"),
    [
        ("husky/husky.urdf", 2, "husky.urdf:97:5: joint 'imu_joint': origin rpy is '$(optenv HUSKY_IMU_RPY"),
        ("humanoid/humanoid.urdf", 2, "humanoid.urdf:288:1: the "),
        ("r2d2.urdf", 0, "other joints that move: 5 continuous, 2 revolute"),
    ],
)  # fmt: skip
def test_robots_that_come_with_pybullet(
    handcart: Callable[..., Said], name: str, status: int, words: str
) -> None:
    found = find_spec("pybullet_data")
    assert found is not None
    assert found.submodule_search_locations
    said = handcart("check", Path(found.submodule_search_locations[0]) / name)
    assert said.status == status
    assert words in said.out + said.err
