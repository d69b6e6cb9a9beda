"""Bullet's own state is looked through before Bullet reads it: it follows whatever stands there."""

from __future__ import annotations

import struct
from collections.abc import Callable

import pytest

pytest.importorskip("pybullet", reason="PyBullet has no wheel for this Python")

from handcart.backends.pybullet.bullet_engine import BulletEngine
from handcart.backends.pybullet.bullet_state import CONTACT_CODE, _chunks, check_state
from handcart.backends.saved_state import NotAState
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.shapes import Box


@pytest.fixture(scope="module")
def states() -> tuple[bytes, bytes, bytes]:
    """Of a box that falls onto a floor: at first, when it lies, and of a world with two boxes."""
    found = []
    for boxes in (1, 2):
        physics = BulletEngine(0.05)
        physics.add_floor(1.0)
        for number in range(boxes):
            _falling(physics, number)
        found.append(physics.state()["bullet"])
        for _ in range(100):
            physics.step()
        found.append(physics.state()["bullet"])
        physics.close()
    return found[0], found[1], found[3]


def _falling(physics: BulletEngine, number: int) -> None:
    p, client = physics.p, physics.client
    half = [0.1, 0.1, 0.1]
    shape = p.createCollisionShape(p.GEOM_BOX, halfExtents=half, physicsClientId=client)
    p.createMultiBody(1.0, shape, -1, (number, 0.0, 0.12), physicsClientId=client)
    assert Box(transform(), (0.2, 0.2, 0.2), "box").size[0] == 2 * half[0]


def test_a_later_state_of_the_same_world_is_taken(states: tuple[bytes, bytes, bytes]) -> None:
    before, after, _ = states
    assert any(each.code == CONTACT_CODE for each in _chunks(after))
    check_state(after, before)
    check_state(before, after)


def changed(content: bytes, code: bytes, offset: int, value: bytes) -> bytes:
    """The same file, some bytes of the first chunk of a kind changed."""
    at = 12
    while at < len(content):
        length = struct.unpack_from("<i", content, at + 4)[0]
        if content[at : at + 4] == code:
            place = at + 24 + (offset if offset >= 0 else length + offset)
            return content[:place] + value + content[place + len(value) :]
        at += 24 + length
    raise AssertionError(code)


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (lambda c: b"", "empty"),
        (lambda c: c[: len(c) // 2], "ends within a chunk"),
        (lambda c: c[:12] + b"\xff" * 5000, "ends within a chunk"),
        (lambda c: b"BULLETf_v326" + c[12:], "another version"),
        (lambda c: changed(c, b"DNA1", 4000, b"\x7f\x7f"), "another version"),
        (lambda c: changed(c, b"MBDY", 0, struct.pack("<d", float("nan"))), "is invalid"),
        (lambda c: changed(c, b"MBDY", 0, struct.pack("<d", 1e300)), "is invalid"),
        (lambda c: changed(c, b"MBDY", 168, struct.pack("<i", 9999)), "another one"),
        (lambda c: changed(c, b"MBDY", -8, struct.pack("<q", 0x41414141)), "points elsewhere"),
        (lambda c: changed(c, b"SHAP", 8, struct.pack("<i", 31)), "another one"),
        (lambda c: changed(c, CONTACT_CODE, -8, struct.pack("<q", 0x41414141)), "isn't there"),
    ],
)
def test_anything_else_is_refused(
    states: tuple[bytes, bytes, bytes], damage: Callable[[bytes], bytes], words: str
) -> None:
    before, after, _ = states
    with pytest.raises(NotAState, match=words):
        check_state(damage(after), before)


def test_a_contact_of_more_points_than_bullet_has_room_for(states: tuple[bytes, bytes, bytes]) -> None:
    before, after, _ = states
    chunk = next(each for each in _chunks(after) if each.code == CONTACT_CODE)
    counts = [at for at in range(0, len(chunk.data) - 4, 4) if chunk.data[at : at + 4] != b"\0" * 4]
    refused = 0
    for at in counts:
        try:
            check_state(changed(after, CONTACT_CODE, at, struct.pack("<i", 500)), before)
        except NotAState as error:
            refused += "more than 4 points" in str(error)
    assert refused == 1


def test_a_world_of_other_bodies(states: tuple[bytes, bytes, bytes]) -> None:
    before, _, two = states
    for kept, now in ((two, before), (before, two)):
        with pytest.raises(NotAState, match="other bodies"):
            check_state(kept, now)
