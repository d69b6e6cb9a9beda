"""Devices on serial lines."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from .serial_device import Device


@pytest.fixture
def device() -> Iterator[Device]:
    made = Device()
    yield made
    made.unplug()
