"""Report on a robot, made from its files alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.evaluation.robot_report.masses import mass_faults
from handcart.evaluation.robot_report.meshes import mesh_row
from handcart.evaluation.robot_report.postures import HandAim, posture_at
from handcart.evaluation.robot_report.report import RobotReport, contents_of, report_of
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.kinematics.urdf_contents import LinkFacts, MeshUse

BEAM = Box(np.eye(4), (0.4, 0.05, 0.05))
L_SHAPE = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]


@pytest.fixture(scope="module")
def librarian() -> RobotReport:
    return report_of(load_robot("librarian"))


def link(mass: float | None, inertia: tuple[float, float, float], x: float = 0.0) -> LinkFacts:
    """A link with its middle of mass at `x`."""
    return LinkFacts("beam", mass, np.array([x, 0.0, 0.0]), np.diag(inertia))


@pytest.mark.parametrize(
    ("facts", "words"),
    [
        (link(2.0, (0.0008, 0.027, 0.027)), ""),
        (link(None, (0.0, 0.0, 0.0)), "no mass"),
        (link(0.0, (0.0, 0.0, 0.0)), "a mass of 0 kg"),
        (link(2.0, (0.0, 0.027, 0.027)), "not positive"),
        (link(2.0, (0.001, 0.01, 0.027)), "isn't that of a body: 0.027 > 0.001 + 0.01"),
        (link(2.0, (0.0008, 0.027, 0.027), 0.5), "300 mm outside its bodies"),
        (link(2.0, (0.3, 0.3, 0.3)), "its inertia is that of 387 mm radius; it is 203 mm"),
        (link(2000.0, (0.8, 27.0, 27.0)), "make 2000000 kg/m³"),
    ],
)
def test_what_is_implausible_about_a_mass_is_told(facts: LinkFacts, words: str) -> None:
    faults = mass_faults(facts, [BEAM])
    assert len(faults) == bool(words)
    assert words in "".join(faults)


def test_a_link_without_bodies_may_have_no_mass_if_no_joint_moves_it() -> None:
    frame = link(None, (0.0, 0.0, 0.0))
    assert mass_faults(frame, []) == []
    assert "a joint moves it" in "".join(mass_faults(frame, [], moves=True))


def test_inertia_that_is_wrong_by_rounding_is_told_with_the_amount() -> None:
    """No engine can take it as it is: see the pads of a gripper, 1.5 mm thick."""
    (fault,) = mass_faults(link(0.05, (6.68e-6, 5.71e-5, 5.04e-5)), [])
    assert fault.endswith("kg m², by 2e-08")
    assert mass_faults(link(0.05, (6.676e-6, 5.7083e-5, 5.0426e-5)), []) == []


@pytest.mark.parametrize("name", ["librarian", "toyama", "atrv", "cart", "el_verde"])
def test_links_of_shipped_robots_are_bodies(name: str) -> None:
    remarks = contents_of(load_robot(name).whole).remarks
    assert [remark for remark in remarks if "inertia" in remark.what or "mass" in remark.what] == []


def prism(path: Path, outline: list[tuple[int, int]], fan: list[tuple[int, ...]]) -> Path:
    """A closed mesh: `outline` between z = 0 and 1, its ends divided into the polygons `fan`."""
    n = len(outline)
    lines = [f"v {x} {y} {z}" for z in (0, 1) for x, y in outline]
    lines += ["f " + " ".join(str(1 + i) for i in reversed(group)) for group in fan]
    lines += ["f " + " ".join(str(1 + n + i) for i in group) for group in fan]
    lines += [f"f {1 + i} {1 + (i + 1) % n} {1 + n + (i + 1) % n} {1 + n + i}" for i in range(n)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_a_concave_mesh_is_told_with_what_it_fills(tmp_path: Path) -> None:
    path = prism(tmp_path / "l.obj", L_SHAPE, [(0, 1, 2, 3), (0, 3, 4, 5)])
    row = mesh_row(MeshUse("corner", "collision", str(path)))
    assert row.filled == pytest.approx(3.0 / 3.5)
    assert row.fault == "concave: fills 86 % of its hull; the hull counts"


def test_a_convex_mesh_is_told_as_such(tmp_path: Path) -> None:
    path = prism(tmp_path / "box.obj", [(0, 0), (2, 0), (2, 1), (0, 1)], [(0, 1, 2, 3)])
    row = mesh_row(MeshUse("brick", "collision", str(path)))
    assert row.filled == pytest.approx(1.0)
    assert row.fault is None


def test_a_missing_mesh_is_told() -> None:
    assert mesh_row(MeshUse("corner", "visual", "/nowhere/l.stl")).fault == "missing"


@pytest.mark.slow
def test_the_librarian_is_without_fault(librarian: RobotReport) -> None:
    assert librarian.warnings == []
    assert [joint.name for joint in librarian.contents.joints][2:8] == [f"joint_{n}" for n in range(1, 7)]
    assert librarian.camera is not None
    assert (librarian.camera.across_deg, librarian.camera.px_per_mm) == (43.6, 2.67)


@pytest.mark.slow
def test_its_reach_is_where_its_work_is(librarian: RobotReport) -> None:
    reach = librarian.reach
    assert reach is not None
    rows = {(row["board_m"], row["line_m"]): row for row in librarian.domains["books"].figures["grasps"]}
    ahead, aside = rows[0.7, 0.0]["ahead_m"], rows[0.7, 0.0]["aside_m"]
    assert ahead is not None
    assert aside is not None
    assert ahead[0] <= 0.1 < 0.47 <= ahead[1]  # tray and shelf
    assert aside[0] <= -0.45 < 0.45 <= aside[1]
    assert reach.radii[1] > 1.2


def test_a_cart_without_an_arm_is_told_of_too() -> None:
    report = report_of(load_robot("cart"))
    assert report.reach is None
    assert report.figures()["reach"] is None
    assert report.warnings == []


def test_a_posture_is_found_for_the_hand() -> None:
    robot = load_robot("librarian")
    angles = posture_at(robot, HandAim((0.1, -0.05, 0.8))).angles
    assert angles is not None
    assert np.allclose(robot.arm_model().forward(np.radians(angles))[:3, 3], (0.1, -0.05, 0.8), atol=1e-6)
    assert posture_at(robot, HandAim((3.0, 0.0, 0.8))).angles is None
