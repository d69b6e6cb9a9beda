"""Rare garbage collection while many states are visited."""

import gc
from contextlib import ExitStack

import pytest

from handcart.networks.chains.few_collections import COLLECTION_THRESHOLDS, few_collections


def test_collections_are_rare_inside_and_as_before_afterwards() -> None:
    before = gc.get_threshold()
    with pytest.raises(KeyError), few_collections():
        assert gc.get_threshold() == COLLECTION_THRESHOLDS
        raise KeyError
    assert gc.get_threshold() == before


def test_overlapping_contexts_restore_after_the_last() -> None:
    before = gc.get_threshold()
    first, second = ExitStack(), ExitStack()
    first.enter_context(few_collections())
    second.enter_context(few_collections())
    first.close()
    assert gc.get_threshold() == COLLECTION_THRESHOLDS
    second.close()
    assert gc.get_threshold() == before
