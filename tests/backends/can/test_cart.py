"""The shipped cart: its file, the kit's checks, and MOVE_TO."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest

from handcart.backends.description.can_spec import CanSpec
from handcart.backends.description.robot_names import SHIPPED_FOLDER
from handcart.backends.loading.robot_loading import load_robot
from handcart.evaluation.conformance.checks.all_checks import checks
from handcart.evaluation.conformance.rig.bench import KitBench
from handcart.evaluation.trials.rig import build_rig
from handcart.files.errors import FileError
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.outcomes.outcome import Success


@pytest.mark.slow
def test_move_to_ends_at_the_right_place() -> None:
    with build_rig(robot="cart", backend="can", seed=1) as rig:
        outcome = rig.do(MoveTo(place="shelf_3"))
        inner: Any = rig.backend.inner
        place, scene = rig.model.places["shelf_3"].pose, inner.scene
        assert isinstance(outcome, Success)
        assert scene.base.distance(place) < 0.01
        assert scene.base.turn(place) < 0.005
        assert scene.contacts == []


LONG = ("drift",)
"""Checks that let minutes of simulated time pass."""


@pytest.mark.parametrize(
    "name", [pytest.param(check, marks=pytest.mark.slow) if check in LONG else check for check in checks()]
)
def test_the_kit_finds_nothing_wrong(name: str) -> None:
    assert checks()[name](KitBench("can", "cart")).wrong == []


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("{node: 2,", "{node: 1,", "left wheel and right wheel have the node 1; allowed: each its own"),
        ("{node: 2,", "{node: 128,", "127"),
        ("interface: virtual ", "interface: socketcam ", "did you mean 'socketcan'"),
        ("sign: -1", "sign: 0", "sign"),
        ("bitrate_kbit_s: 500", "bitrate_kbit_s: 300", "bitrate_kbit_s"),
    ],
)
def test_what_is_wrong_in_the_section_can_is_told_with_its_place(
    tmp_path: Path, before: str, after: str, message: str
) -> None:
    path = Path(shutil.copytree(SHIPPED_FOLDER / "cart", tmp_path / "cart")) / "robot.yaml"
    text = path.read_text(encoding="utf-8")
    assert before in text
    path.write_text(text.replace(before, after), encoding="utf-8")
    with pytest.raises(FileError, match=message) as error:
        load_robot(str(path))
    assert f"{path}:" in str(error.value)


def test_counts_for_a_metre() -> None:
    wheel = {"node": 3, "counts_per_rev": 1000, "gear_ratio": 10.0, "sign": -1}
    spec = CanSpec.model_validate(
        {
            "interface": "virtual",
            "channel": "x",
            "bitrate_kbit_s": 500,
            "left": wheel,
            "right": wheel | {"node": 4, "sign": 1},
        }
    )
    assert spec.left.counts_per_m(0.1) == pytest.approx(-15915.494, rel=1e-6)
    assert [item.node for item in spec.wheels] == [3, 4]
