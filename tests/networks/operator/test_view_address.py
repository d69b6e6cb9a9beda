"""The address of a run's page, noted for its owner; no other text counts as one."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.networks.operator.view_address import (
    ADDRESS_FILE,
    MAX_ADDRESS_BYTES,
    forget_address,
    note_address,
    view_address,
)

OURS = "http://127.0.0.1:8765/#token=" + "aB3_-" * 8


def test_address_is_noted_for_its_owner_alone_and_forgotten(tmp_path: Path) -> None:
    assert view_address(tmp_path) is None
    note_address(tmp_path, OURS)
    assert view_address(tmp_path) == OURS
    assert (tmp_path / ADDRESS_FILE).stat().st_mode & 0o777 == 0o600
    forget_address(tmp_path)
    assert view_address(tmp_path) is None
    forget_address(tmp_path)


@pytest.mark.parametrize(
    "words",
    [
        "",
        "http://127.0.0.1:8765/#token=",
        "http://127.0.0.1:876543/#token=x",
        "http://127.0.0.2:8765/#token=x",
        "http://127a0.0.1:8765/#token=x",
        "https://127.0.0.1:8765/#token=x",
        "http://127.0.0.1:8765/#token=x y",
        "http://127.0.0.1:8765/#token=x\n",
        "http://127.0.0.1:8765/#token=\u00e9",
        "http://127.0.0.1:8765/#token=" + "x" * MAX_ADDRESS_BYTES,
    ],
)
def test_what_is_no_page_of_this_machine_is_no_address(tmp_path: Path, words: str) -> None:
    (tmp_path / ADDRESS_FILE).write_text(words, encoding="utf-8")
    assert view_address(tmp_path) is None


def test_a_link_or_a_folder_is_no_address(tmp_path: Path) -> None:
    """Also where what it leads to would be one."""
    (tmp_path / "elsewhere").write_text(OURS)
    (tmp_path / ADDRESS_FILE).symlink_to(tmp_path / "elsewhere")
    assert view_address(tmp_path) is None
    forget_address(tmp_path)
    assert (tmp_path / "elsewhere").exists()
    (tmp_path / ADDRESS_FILE).mkdir()
    assert view_address(tmp_path) is None
