"""States as bytes: a state is restored as it was saved, or it is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from handcart.backends.saved_state import NotAState, pack, unpack

STATE: dict[str, Any] = {
    "numbers": [1, -2.5, True, None, 2**100, math.inf],
    "words": "naïve",
    "bytes": b"\0\xff",
    "arrays": {
        "poses": np.arange(6.0).reshape(2, 3),
        "none": np.empty((0, 2)),
        "grey": np.array([[7]], np.uint8),
    },
}
PICKLES = (
    b"cposix\nsystem\n(Vtrue\ntR.",
    b"\x80\x04\x95\x1a\x00\x00\x00\x00\x00\x00\x00\x8c\x08builtins\x94\x8c\x05print\x94\x93\x94.",
    b"ctransitions\nMachine\n)\x81.",
)


def test_what_was_kept_comes_back() -> None:
    again = unpack(pack(STATE))
    assert {key: again[key] for key in ("numbers", "words", "bytes")} == {
        key: STATE[key] for key in ("numbers", "words", "bytes")
    }
    for name, array in STATE["arrays"].items():
        assert again["arrays"][name].dtype == array.dtype
        assert np.array_equal(again["arrays"][name], array)
        assert again["arrays"][name].flags.writeable


def test_same_state_same_bytes() -> None:
    assert pack(STATE) == pack(unpack(pack(STATE)))


def test_any_flipped_bit_is_found() -> None:
    whole = pack(STATE)
    for place in range(len(whole)):
        for bit in range(8):
            damaged = bytearray(whole)
            damaged[place] ^= 1 << bit
            with pytest.raises(NotAState):
                unpack(bytes(damaged))


def test_truncated_anywhere() -> None:
    whole = pack(STATE)
    for length in range(len(whole)):
        with pytest.raises(NotAState):
            unpack(whole[:length])


@pytest.mark.parametrize(
    "content", [*PICKLES, b"", b"nonsense", b"handcart-state/2 " + b"0" * 64 + b"\n2\n{}"]
)
def test_what_is_no_state_is_refused_and_runs_nothing(
    content: bytes, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(NotAState, match="no saved state"):
        unpack(content)
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize(
    "value",
    [object(), print, {1: 2}, {"$array": 1}, np.array([object()]), np.array(["x"]), 1j, {"a": {2}}],
)
def test_what_is_no_plain_data_is_not_kept(value: object) -> None:
    with pytest.raises(TypeError):
        pack({"value": value})


def sealed(text: bytes, blobs: bytes = b"") -> bytes:
    """Bytes with the right checksum about any JSON."""
    from handcart.backends.saved_state import STATE_FORMAT, digest

    body = b"%d\n%b%b" % (len(text), text, blobs)
    return b"%b %b\n%b" % (STATE_FORMAT.encode(), digest(body).encode(), body)


@pytest.mark.parametrize(
    ("text", "blobs"),
    [
        (b'{"$array":"object","shape":[1]}', b"\0" * 8),
        (b'{"$array":"float64","shape":[-1]}', b""),
        (b'{"$array":"float64","shape":[4294967296,4294967296]}', b""),
        (b'{"$array":"float64","shape":[1,1,1,1,1]}', b"\0" * 8),
        (b'{"$array":"float64","shape":[2]}', b"\0" * 8),
        (b'{"$array":"bool","shape":[1]}', b"\2"),
        (b'{"$bytes":-1}', b""),
        (b'{"$int":"1e9"}', b""),
        (b'{"$float":"1"}', b""),
        (b'{"$array":"float64","shape":[0],"more":1}', b"left over"),
        (b"[" * 100 + b"]" * 100, b""),
        (b"[" * 5000 + b"]" * 5000, b""),
        (b"{", b""),
        (b"1", b"left over"),
    ],
)
def test_right_checksums_about_nonsense(text: bytes, blobs: bytes) -> None:
    with pytest.raises(NotAState, match="no saved state"):
        unpack(sealed(text, blobs))
