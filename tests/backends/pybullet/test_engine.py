from __future__ import annotations

import sys

import pytest

from handcart.backends.pybullet import bullet


@pytest.mark.parametrize(
    ("python", "how"),
    [
        ((3, 11), "pip install 'handcart[pybullet]'"),
        ((3, 12), "PyBullet has no wheel for Python 3.12"),
        ((3, 13), "PyBullet has no wheel for Python 3.13"),
    ],
)
def test_where_pybullet_is_missing_the_error_says_how_to_get_it(
    monkeypatch: pytest.MonkeyPatch, python: tuple[int, int], how: str
) -> None:
    monkeypatch.setattr(bullet, "find_spec", lambda name: None)
    monkeypatch.setattr(sys, "version_info", (*python, 0))
    bullet.bullet.cache_clear()
    with pytest.raises(bullet.MissingPyBullet, match="not installed") as missing:
        bullet.bullet()
    assert how in str(missing.value)
