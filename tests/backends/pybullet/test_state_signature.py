"""Bullet's own state is read only if this user saved it: Bullet follows every pointer in it."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("pybullet", reason="PyBullet has no wheel for this Python")

from handcart.backends.pybullet.bullet_engine import BulletEngine
from handcart.backends.pybullet.state_signature import KEY_FILE
from handcart.backends.saved_state import NotAState


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    return tmp_path / "handcart"


def falling(boxes: int) -> BulletEngine:
    """Return an engine with some boxes above a floor."""
    physics = BulletEngine(0.05)
    physics.add_floor(1.0)
    p, client = physics.p, physics.client
    for number in range(boxes):
        shape = p.createCollisionShape(p.GEOM_BOX, halfExtents=[0.1] * 3, physicsClientId=client)
        p.createMultiBody(1.0, shape, -1, (number, 0.0, 0.3), physicsClientId=client)
    return physics


@pytest.fixture
def physics() -> Iterator[BulletEngine]:
    engine = falling(1)
    yield engine
    engine.close()


def height(physics: BulletEngine) -> float:
    found: float = physics.p.getBasePositionAndOrientation(1, physicsClientId=physics.client)[0][2]
    return found


def test_an_own_state_is_restored_in_another_engine(physics: BulletEngine, home: Path) -> None:
    for _ in range(100):
        physics.step()
    other = falling(1)
    other.set_state(physics.state())
    assert height(other) == pytest.approx(height(physics), abs=1e-9)
    assert height(other) < 0.15
    other.close()
    assert stat.S_IMODE((home / KEY_FILE).stat().st_mode) == 0o600


@pytest.mark.parametrize(
    "change",
    [
        lambda state: state | {"bullet": state["bullet"][:-1]},
        lambda state: state | {"bullet": state["bullet"][:2000] + b"\x41" * 8 + state["bullet"][2008:]},
        lambda state: state | {"signature": bytes(32)},
        lambda state: state | {"signature": b""},
    ],
    ids=["cut", "changed", "forged", "unsigned"],
)
def test_a_changed_state_is_refused(
    physics: BulletEngine, change: Callable[[dict[str, Any]], dict[str, Any]]
) -> None:
    with pytest.raises(NotAState, match="its signature is wrong; allowed: a state saved by the same user"):
        physics.set_state(change(physics.state()))


def test_a_state_of_other_bodies_is_refused(physics: BulletEngine) -> None:
    other = falling(2)
    for one, two in ((physics, other), (other, physics)):
        with pytest.raises(NotAState, match="for the same bodies"):
            one.set_state(two.state())
    other.close()


def test_a_state_of_another_user_is_refused(
    physics: BulletEngine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    state = physics.state()
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "another"))
    with pytest.raises(NotAState, match="its signature is wrong"):
        physics.set_state(state)


def test_without_a_key_folder_a_process_restores_its_own_states(
    physics: BulletEngine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "file"))
    physics.set_state(physics.state())
    assert os.listdir(tmp_path) == ["file"]
