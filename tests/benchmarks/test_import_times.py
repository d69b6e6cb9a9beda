"""What `import handcart` and `handcart --help` cost."""

from __future__ import annotations

import pytest

from benchmarks.import_times import MOST_MS, beyond_bare_ms


@pytest.mark.slow
def test_importing_and_help_take_little() -> None:
    took = beyond_bare_ms(9, min)
    assert took.keys() == MOST_MS.keys()
    assert {name: ms for name, ms in took.items() if ms > MOST_MS[name]} == {}
