from __future__ import annotations

import numpy as np
import pytest

from handcart.backends.simulation.books import textures
from handcart.backends.simulation.books.textures import draw_label, draw_spine, label_fonts
from handcart.robotics.perception.landmarks.tag_reader import read_tags


def test_spines_are_the_same_for_the_same_seed() -> None:
    first, again = (draw_spine(22, 200, 120, 7, "512.7 NAG", seed=3) for _ in range(2))
    assert first.shape == (1600, 176) and first.dtype == np.uint8
    assert np.array_equal(first, again)
    assert not np.array_equal(first, draw_spine(22, 200, 120, 7, "512.7 NAG", seed=4))


@pytest.mark.parametrize("font", label_fonts())
def test_labels_fit_the_thinnest_spine_in_every_face(font: str) -> None:
    spine = draw_spine(15, 180, 60, 249, "512.7 NAG", font)
    foot = spine[-round((textures.LABEL_FROM_FOOT_MM + 20) * textures.PX_PER_MM), :]
    assert (foot > 200).sum() >= 0.5 * textures.LABEL_WIDTH_MM * textures.PX_PER_MM


def test_tags_are_at_their_places_and_smeared_ones_unreadable() -> None:
    for seed in range(8):
        clean, smeared = (
            draw_spine(20, 200, 100, 31 * seed, "512.7 NAG", seed=seed, smear=s) for s in (False, True)
        )
        small = np.ascontiguousarray(clean[::3, ::3])
        (tag,) = read_tags(small)
        assert tag.id == 31 * seed
        assert tag.corners.mean(axis=0) * 3 == pytest.approx((79, 14 * 8), abs=4)
        assert read_tags(np.ascontiguousarray(smeared[::3, ::3])) == []


def test_what_does_not_fit_is_an_error() -> None:
    with pytest.raises(ValueError, match="no room"):
        draw_spine(12, 200, 100, tag_id=1)
    with pytest.raises(ValueError, match="longest"):
        draw_label("512.123456 ABCDEFG")
