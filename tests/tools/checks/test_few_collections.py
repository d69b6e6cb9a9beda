"""Rare garbage collection while a task is checked."""

import gc

import pytest

from handcart.tools.checks.few_collections import COLLECTION_THRESHOLDS, few_collections


def test_collections_are_rare_inside_and_as_before_afterwards() -> None:
    before = gc.get_threshold()
    with pytest.raises(KeyError), few_collections():
        assert gc.get_threshold()[0] == COLLECTION_THRESHOLDS[0]
        raise KeyError
    assert gc.get_threshold() == before
