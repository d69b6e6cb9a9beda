"""The pictures of `python -m benchmarks.blocks.april_tags`, a few of them."""

from __future__ import annotations

import pytest

from benchmarks.blocks.april_tags import Count, ours, stock, tagged, untagged


@pytest.mark.parametrize(("bits", "least", "most"), [(0, 11, 12), (1, 11, 12), (2, 0, 0)])
def test_tags_with_up_to_one_damaged_bit_are_read(bits: int, least: int, most: int) -> None:
    count = Count().plus(picture := tagged(2, bits), ours(picture.image))
    assert least <= count.read <= most
    assert (count.there, count.false) == (12, 0)


def test_stock_detector_reads_what_the_benchmark_draws() -> None:
    picture = tagged(2, 0)
    assert len(stock()(picture.image) & picture.ids) >= 11


@pytest.mark.parametrize("seed", range(3))
def test_picture_without_a_tag_has_no_id(seed: int) -> None:
    assert ours(untagged(seed).image) == set()


def test_false_id_is_counted_as_one() -> None:
    picture = tagged(2, 0)
    assert Count().plus(picture, {*picture.ids, -1}) == Count(12, 12, 1)
