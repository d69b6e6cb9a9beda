"""Functions that are compiled on their first call."""

import copy
import subprocess
import sys

import pytest

from handcart.robotics.numerics.compiled import compiled


@compiled
def _doubled(x: float) -> float:
    """Twice as much."""
    return 2.0 * x


@compiled
def _tripled(x: float) -> float:
    return _doubled(x) + x


def test_a_compiled_function_may_call_another() -> None:
    assert _tripled(2.0) == 6.0
    assert _tripled(3) == 9.0  # another type is compiled as well


def test_it_is_told_of_like_the_function() -> None:
    assert _doubled.__name__ == "_doubled"
    assert _doubled.__doc__ == "Twice as much."


@pytest.mark.slow
def test_nothing_is_imported_before_something_is_computed() -> None:
    code = "import sys, handcart.evaluation.viewing.playback.playback as _\n"
    code += "import handcart.robotics.navigation.routes.ways as w"
    words = [sys.executable, "-c", f"{code}; print('numba' in sys.modules)"]
    assert subprocess.run(words, capture_output=True, text=True, timeout=60, check=True).stdout == "False\n"


def test_it_is_sent_to_another_process_by_its_name() -> None:
    assert _tripled.__reduce__() == "_tripled"
    assert copy.deepcopy(_tripled) is _tripled


def test_where_machine_code_cannot_be_kept_it_is_made_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    def nowhere(*_: object) -> None:
        raise RuntimeError("cannot cache function: no locator available")

    monkeypatch.setattr("numba.core.dispatcher.Dispatcher.enable_caching", nowhere)

    def halved(x: float) -> float:
        return 0.5 * x

    assert compiled(halved)(3.0) == 1.5
