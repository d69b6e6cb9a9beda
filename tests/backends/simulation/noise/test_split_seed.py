"""Seeds of runs that branch: earlier draws are kept, later ones differ from branch to branch."""

from __future__ import annotations

from handcart.backends.simulation.noise.keyed_noise import keyed, keyed_normal
from handcart.backends.simulation.noise.split_seed import SplitSeed


def drawn(seed: int, purpose: str, period: int) -> float:
    return float(keyed_normal(seed, purpose, period, 3)[2])


def test_an_unsplit_one_draws_as_the_plain_one() -> None:
    whole = SplitSeed(7)
    assert (whole, f"{whole}", hash(whole)) == (7, "7", hash(7))
    assert drawn(whole, "slip", 3) == drawn(7, "slip", 3)
    assert keyed(whole, "wheels").random() == keyed(7, "wheels").random()


def test_branches_share_what_was_drawn_before_them() -> None:
    whole = SplitSeed(7)
    drawn(whole, "slip", 3)
    keyed(whole, "wheels").random()
    one, other = whole.split(1), whole.split(2)
    assert drawn(one, "slip", 2) == drawn(other, "slip", 3 - 1) == drawn(7, "slip", 2)
    assert drawn(one, "slip", 3) == drawn(7, "slip", 3)
    assert keyed(one, "wheels").random() == keyed(7, "wheels").random()
    assert len({drawn(item, "slip", 4) for item in (7, one, other)}) == 3
    assert len({drawn(item, "gyros", 0) for item in (7, one, other)}) == 3  # not requested before


def test_a_branch_of_a_branch_keeps_what_each_has_drawn() -> None:
    whole = SplitSeed(7)
    drawn(whole, "slip", 3)
    one = whole.split(1)
    kept = drawn(one, "slip", 5)
    late = one.split(4)
    assert drawn(late, "slip", 3) == drawn(7, "slip", 3)
    assert drawn(late, "slip", 5) == kept
    assert drawn(late, "slip", 4) == drawn(one, "slip", 4)
    assert drawn(late, "slip", 6) not in (drawn(one, "slip", 6), drawn(7, "slip", 6))


def test_the_same_branch_draws_the_same() -> None:
    one, same = SplitSeed(7).split(9), SplitSeed(7).split(9)
    assert drawn(one, "slip", 1) == drawn(same, "slip", 1)
    assert drawn(7, "slip", 1) == drawn(SplitSeed(7), "slip", 1)  # a cache belongs to one of them


def test_cheap_noise_is_the_first_noise_of_its_generator() -> None:
    for seed, purpose, period, size in (
        (0, "gyros", 0, 3),
        (2**40 + 1, "joints", 77, 6),
        (3, "joints", 5, 400),
    ):
        expected = keyed(seed, purpose, period).standard_normal(size)
        assert (keyed_normal(seed, purpose, period, size) == expected).all()
