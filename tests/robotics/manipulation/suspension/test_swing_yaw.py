import numpy as np
import pytest

from handcart.robotics.manipulation.suspension.swing_yaw import fit_swing_yaw

YAW, SPREAD, NOISE = -0.8e-3, 0.4e-3, 0.2e-3


def headings(seed: int, stops: int = 21, looks: int = 2, swings: int = 2) -> np.ndarray:
    rng = np.random.default_rng(seed)
    steps = rng.normal(YAW * swings, SPREAD * np.sqrt(swings), stops - 1)
    at_stops = 0.3 + np.concatenate([[0.0], np.cumsum(steps)])
    return at_stops[:, None] + rng.normal(0.0, NOISE, (stops, looks))


def test_mean_and_spread_are_as_sure_as_they_say() -> None:
    found = [fit_swing_yaw(headings(seed), 2) for seed in range(200)]
    off = np.array([yaw.yaw_per_swing for yaw in found]) - YAW
    assert off.std() == pytest.approx(np.mean([yaw.sigma for yaw in found]), rel=0.15)
    spreads = np.array([yaw.spread for yaw in found])
    assert spreads.mean() == pytest.approx(SPREAD, rel=0.05)
    assert spreads.std() == pytest.approx(np.mean([yaw.spread_sigma for yaw in found]), rel=0.25)
    assert np.mean([yaw.noise for yaw in found]) == pytest.approx(NOISE, rel=0.05)


def test_a_base_that_stands_firm() -> None:
    still = np.random.default_rng(1).normal(0.0, NOISE, (21, 2))
    found = fit_swing_yaw(still, 2)
    assert abs(found.yaw_per_swing) < 4 * found.sigma
    assert found.spread < 0.15e-3


@pytest.mark.parametrize(("stops", "looks", "swings"), [(3, 2, 2), (9, 1, 2), (9, 2, 0)])
def test_too_little_to_tell(stops: int, looks: int, swings: int) -> None:
    with pytest.raises(ValueError, match=r"can't determine the yaw; needed: more than 3 stops, 2 looks"):
        fit_swing_yaw(np.zeros((stops, looks)), swings)
