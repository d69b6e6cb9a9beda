import signal
from collections.abc import Iterator

import pytest

from handcart.tools.terminal.asked_to_end import AskedToEnd

ASKING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@pytest.fixture(autouse=True)
def handlers() -> Iterator[None]:
    before = {number: signal.getsignal(number) for number in ASKING}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("number", ASKING)
def test_what_catches_everything_swallows_no_signal(number: signal.Signals) -> None:
    over = AskedToEnd()
    assert (bool(over), over.status) == (False, 0)
    try:
        signal.raise_signal(number)
    except BaseException:
        pytest.fail("it came up inside")
    assert (bool(over), over.status) == (True, 128 + number)


def test_the_first_says_the_status() -> None:
    over = AskedToEnd()
    signal.raise_signal(signal.SIGTERM)
    signal.raise_signal(signal.SIGINT)
    assert over.status == 143
