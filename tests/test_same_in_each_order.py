"""What would make tests depend on those before them, or parse all sources in each process, is off."""

from __future__ import annotations

import gc
import sys
from importlib.machinery import SourceFileLoader

import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.internal.conjecture import providers

from handcart.robotics.geometry import pose2


def test_examples_do_not_depend_on_imported_modules() -> None:
    given(st.integers())(lambda _: None)()
    assert "handcart.robotics.geometry.pose2" in sys.modules
    assert len(providers.HypothesisProvider(None)._local_constants) == 0


def test_sources_are_imported_without_rewritten_asserts() -> None:
    """Python's own machine code of a module is then shared with the processes that tests start."""
    assert type(pose2.__loader__) is SourceFileLoader


def test_asserts_of_tests_are_rewritten() -> None:
    with pytest.raises(AssertionError, match="assert 1 == 2"):
        assert len([0]) == 2


def test_garbage_is_collected_while_tests_run() -> None:
    assert gc.isenabled()
