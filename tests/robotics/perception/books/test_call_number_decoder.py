from __future__ import annotations

import numpy as np

from handcart.robotics.numerics.arrays import SingleArray
from handcart.robotics.perception.books.call_number_decoder import (
    CALL_NUMBER_SYMBOLS,
    CallNumberDecoder,
    Decoded,
)

CHARACTERS = ["", *CALL_NUMBER_SYMBOLS, *"abcdefghijklmnopqrstuvwxyz", "中", " "]
DECODER = CallNumberDecoder(CHARACTERS)


def _outputs(text: str, sure: float = 0.98) -> SingleArray:
    """What a recogniser says that reads `text` with a blank ("_") between the symbols."""
    rows = np.full((len(text), len(CHARACTERS)), (1 - sure) / len(CHARACTERS), dtype=np.float32)
    for row, character in zip(rows, text, strict=True):
        row[CHARACTERS.index("" if character == "_" else character)] += sure
    return rows


def _decoded(outputs: SingleArray) -> Decoded:
    decoded = DECODER.decode(outputs)
    assert decoded is not None
    return decoded


def test_a_clear_reading_is_taken_as_it_is() -> None:
    decoded = _decoded(_outputs("5_112_..7_ NA_GG"))
    assert decoded.text == "512.7 NAG"
    assert decoded.confidence > 0.9


def test_a_blank_tells_two_symbols_from_one() -> None:
    assert _decoded(_outputs("5_51 A_AB")).text == "551 AAB"
    assert _decoded(_outputs("555_1_2 A_BBC")).text == "512 ABC"


def test_place_decides_between_look_alikes() -> None:
    assert _decoded(_outputs("5O2.l O1o")).text == "502.1 OIO"


def test_other_text_is_not_bent_into_a_call_number() -> None:
    assert DECODER.decode(_outputs("RIVERS", 0.999)) is None
    assert DECODER.decode(_outputs("5中2 ABC", 0.999)) is None
    assert DECODER.decode(_outputs("512 AB")) is None


def test_doubt_lowers_confidence() -> None:
    outputs = _outputs("512 NAG")
    letter = outputs[6]
    letter[CHARACTERS.index("C")] = letter[CHARACTERS.index("G")]
    assert _decoded(outputs).confidence < 0.6


def test_other_numbers_of_letters_are_read_where_they_are_known() -> None:
    decoder = CallNumberDecoder(CHARACTERS, {(0, 2), (6, 4)})
    for text in ("512 NA", "512.123456 NAGA"):
        decoded = decoder.decode(_outputs(text))
        assert decoded is not None and decoded.text == text and decoded.confidence > 0.9
