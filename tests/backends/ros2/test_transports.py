"""Nodes share no memory with others by default, because a killed one may keep a mutex in it locked."""

from __future__ import annotations

import os
from pathlib import Path
from xml.etree import ElementTree

import pytest

from handcart.backends.ros2.wire.transports import (
    CHOICES,
    LOCAL_FILE,
    PROFILES,
    RANGE,
    TRANSPORTS,
    environment,
    shares_memory,
    transport_variables,
)

FAST = "rmw_fastrtps_cpp"


@pytest.fixture(autouse=True)
def nothing_chosen(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave all transports to us."""
    for name in (*CHOICES, RANGE):
        monkeypatch.delenv(name, raising=False)


def test_nodes_use_udp_and_stay_on_this_machine_where_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    assert transport_variables(FAST) == {TRANSPORTS: "UDPv4"}
    monkeypatch.setenv(RANGE, "LOCALHOST")
    variables = transport_variables(FAST)
    assert variables == {RANGE: "SYSTEM_DEFAULT", PROFILES: str(LOCAL_FILE)}
    words = [item.text for item in ElementTree.parse(variables[PROFILES]).iter() if item.text]
    assert "127.0.0.1" in words  # no node beyond this machine hears it
    assert words.count("UDPv4") == 1
    assert "SHM" not in words


@pytest.mark.parametrize("name", CHOICES)
def test_transports_of_the_user_are_kept(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(name, "LARGE_DATA")
    assert not transport_variables(FAST)


@pytest.mark.parametrize("discovery", ["", "LOCALHOST"])
def test_other_middleware_is_left_as_it_is(discovery: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(RANGE, discovery)
    assert not transport_variables("rmw_cyclonedds_cpp")


def test_the_environment_is_as_before_afterwards(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(RANGE, "LOCALHOST")
    before = dict(os.environ)
    with pytest.raises(ZeroDivisionError), environment({RANGE: "SUBNET", TRANSPORTS: "UDPv4"}):
        assert (os.environ[RANGE], os.environ[TRANSPORTS]) == ("SUBNET", "UDPv4")
        raise ZeroDivisionError
    assert dict(os.environ) == before


def test_shared_memory_is_seen_and_assumed_where_unknown(tmp_path: Path) -> None:
    file = tmp_path / "maps"
    assert shares_memory(file)
    for line, shared in (
        ("7f00 rw-s /dev/shm/fastdds_port7411", True),
        ("7f00 r-xp /usr/lib/libc.so", False),
    ):
        file.write_text(line, encoding="utf-8")
        assert shares_memory(file) is shared
