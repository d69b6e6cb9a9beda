import pytest

from handcart.robotics.perception.books.call_number import CallNumber, edit_distance, parse, snap


def test_text_is_parsed_and_written_back() -> None:
    assert parse("512.7 NAG") == CallNumber("512", "7", "NAG")
    assert str(parse(" 512 . 7nag ")) == "512.7 NAG"
    assert str(parse("031 ABC")) == "031 ABC"


@pytest.mark.parametrize(
    "text", ["", "512.7", "51.7 NAG", "512,7 NAG", "512.7 NAGAS", "5l2.7 NAG", "٥١٢ NAG"]
)
def test_other_text_is_no_call_number(text: str) -> None:
    assert parse(text) is None


def _number(text: str) -> CallNumber:
    number = parse(text)
    assert number is not None
    return number


def test_shelf_order_goes_digit_by_digit() -> None:
    texts = ["031 ABC", "512 ZZZ", "512.15 AAA", "512.15 AAB", "512.7 AAA", "513 AAA"]
    numbers = [_number(text) for text in texts]
    shuffled = [numbers[i] for i in (3, 0, 5, 2, 4, 1)]
    assert sorted(shuffled) == numbers
    assert parse("512.70 NAG") == parse("512.7 NAG")
    assert _number("512.70 NAG") <= _number("512.7 NAG")


def test_snapping_takes_the_nearest_and_refuses_ties() -> None:
    catalogue = [_number(text) for text in ("512.7 NAG", "512.7 NAB", "633.1 TOL")]
    assert snap("633.1 T0L", catalogue) == catalogue[2]
    assert snap("512.7NAG", catalogue) == catalogue[0]
    assert snap("512.7 NAX", catalogue) is None
    assert snap("999 QQQ", catalogue) is None
    assert snap("512.7 NAG", []) is None


def test_edit_distance_is_capped() -> None:
    assert edit_distance("abc", "abd", 2) == 1
    assert edit_distance("abc", "bc", 2) == 1
    assert edit_distance("abc", "xyz", 1) == 2
