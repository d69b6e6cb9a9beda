"""Functions are ready before a control loop begins."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

MODULE = """\
from handcart.robotics.numerics.compiled import compiled

@compiled
def doubled(value):
    return 2.0 * value
"""
FIRST = "from some_kernel import doubled; assert doubled(1.5) == 3.0"
SECOND = """\
from handcart.robotics.numerics.compiled import hearing_of_compiling
from handcart.robotics.numerics.compiling_before import compile_before
from some_kernel import doubled

assert compile_before() == READY, len(doubled.dispatcher.overloads)
compiling = []
with hearing_of_compiling(compiling.append):
    assert doubled(2.5) == 5.0
assert compiling == COMPILING, compiling
"""


@pytest.mark.slow
@pytest.mark.parametrize("rehearsed", [True, False])
def test_what_was_compiled_before_is_loaded(tmp_path: Path, rehearsed: bool) -> None:
    (tmp_path / "some_kernel.py").write_text(MODULE, encoding="utf-8")
    ready, compiling = (1, []) if rehearsed else (0, [True, False])
    second = SECOND.replace("READY", str(ready)).replace("COMPILING", str(compiling))
    for words in (FIRST, second) if rehearsed else (second,):
        done = subprocess.run([sys.executable, "-c", words], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
