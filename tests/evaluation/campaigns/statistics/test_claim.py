"""Claims about a success rate, and the reports that CI servers read."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from xml.etree.ElementTree import parse

import numpy as np
import pytest

from benchmarks.campaigns.walk import walk
from handcart.evaluation.campaigns.data.trial import Trial
from handcart.evaluation.campaigns.statistics.claim import NoClaim, RateClaim, Settling
from tests.tools.conftest import Said
from tests.tools.conftest import handcart as handcart


def trial(seed: int, success: bool = True) -> Trial:
    return Trial(seed, 0 if success else 3, {"outcome": "", "reason": "", "metrics": {}})


@pytest.mark.parametrize("words", ["p", "p > 95", "p >= .9", "q < 0.5", "p > 0.0", "p > 1"])
def test_what_claims_nothing_is_refused(words: str) -> None:
    with pytest.raises(NoClaim, match="allowed"):
        RateClaim.of(words)


def test_it_is_sure_when_it_may_be() -> None:
    above, below = RateClaim.of("p > 0.95"), RateClaim.of("p<.5")
    assert above.verdict(170, 170) is True
    assert above.verdict(50, 50) is None
    assert above.verdict(10, 20) is False
    assert below.verdict(0, 20) is True
    assert below.verdict(20, 20) is False


def test_it_is_seldom_wrong_however_often_it_is_asked() -> None:
    chance, claim = np.random.default_rng(3), RateClaim.of("p > 0.8")
    wrong = 0
    for _ in range(400):
        successes = np.cumsum(chance.random(300) < 0.8)
        wrong += any(claim.verdict(int(s), at + 1) is True for at, s in enumerate(successes))
    assert wrong / 400 <= 0.05


def test_trials_count_in_the_order_of_their_seeds() -> None:
    """Otherwise short trials would count first."""
    settling = Settling(RateClaim.of("p < 0.5"), range(40))
    assert not any(settling.hear(trial(seed, False)) for seed in range(1, 40))
    assert (settling.count, settling.verdict) == (0, None)
    assert settling.hear(trial(0, False))
    assert settling.verdict
    assert settling.count < 12


@pytest.mark.parametrize(
    ("claim", "status", "words", "failed"),
    [
        ("p > 0.6", 0, "p > 0.6: yes, sure after", 0),
        ("p < 0.6", 3, "p < 0.6: no, sure after", 1),
        ("p > 0.96", 3, "300 trials are not enough to be sure", 1),
    ],
)
def test_a_campaign_ends_when_it_is_sure(
    handcart: Callable[..., Said], tmp_path: Path, claim: str, status: int, words: str, failed: int
) -> None:
    junit = tmp_path / "junit.xml"
    command = ["campaign", walk(tmp_path), "--level", "network", "--trials", 300, "--out", tmp_path / "out"]
    command += ["--until", claim, "--junit", junit]
    said = handcart(*command)
    assert (said.status, words in said.out) == (status, True), said.out
    suite = parse(junit).getroot()
    assert suite.get("failures") == str(failed)
    assert handcart(*command).out == said.out


def test_the_network_alone_ends_as_check_reckons(handcart: Callable[..., Said], tmp_path: Path) -> None:
    command = ["campaign", walk(tmp_path), "--level", "network", "--trials", 2000]
    alone = handcart(*command, "--jobs", 1)
    assert "they agree" in alone.out
    assert alone.status == 0
    (tmp_path / "walk.yaml").write_text((tmp_path / "walk.yaml").read_text().replace(", p: 0.7", ""))
    said = handcart(*command)
    assert said.status == 2
    assert "walk.yaml:11:5: no probability `p`" in said.err
