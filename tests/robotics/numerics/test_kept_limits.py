"""Limits of errors of which a part is bounded."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.numerics.kept_limits import BEYOND_3_SIGMA, uniform_limits

COUNT = 400_000


@pytest.mark.parametrize("bounds", [(0.025,), (0.0125, 0.0125), (0.025, 0.02, 0.01), (0.0, 0.0)])
def test_uniform_errors_and_noise_keep_their_limit(bounds: tuple[float, ...]) -> None:
    rng, sigma = np.random.default_rng(7), 0.004
    errors = sum(rng.uniform(-bound, bound, COUNT) for bound in bounds) + rng.normal(0.0, sigma, COUNT)
    (limit,) = uniform_limits(np.array([bounds]), np.array([sigma]))
    assert np.mean(np.abs(errors) > limit) == pytest.approx(BEYOND_3_SIGMA, abs=4e-4)


def test_no_errors_have_no_limit() -> None:
    assert uniform_limits(np.zeros((1, 2)), np.zeros(1)) == pytest.approx([0.0], abs=1e-9)
