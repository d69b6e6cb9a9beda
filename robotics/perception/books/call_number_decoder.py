"""Decoding of a text recogniser's letter probabilities to the likeliest call number."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray, SingleArray

CALL_NUMBER_SYMBOLS = "0123456789.ABCDEFGHIJKLMNOPQRSTUVWXYZ"
# Look-alikes that a recogniser trained on all scripts may return for our symbols. Digits and letters share
# some: the position in the call number decides which of the two was meant.
_ALIASES = {
    **{letter: letter + letter.lower() for letter in "CJKMPSUVWXYZ"},
    "0": "0OoD",
    "1": "1lI|",
    ".": ".,·。．、・",
    "I": "I1l|",
    "O": "Oo0",
    "A": "AΑА",
    "B": "BΒВ",
    "E": "EΕЕ",
    "H": "HΗН",
    "N": "NΝ",
    "T": "TΤТ",
}
_DIGITS, _POINT, _LETTERS = range(10), 10, range(11, 37)
_UNLIKELY = 1e-3
USUAL_LETTERS, USUAL_DECIMALS = 3, 4
USUAL_FORMS = frozenset((decimals, USUAL_LETTERS) for decimals in range(USUAL_DECIMALS + 1))
_BEAM = 12


class Decoded(NamedTuple):
    """Text in the form of a call number, decoded from a recogniser's output.

    `confidence`, 0 to 1, is the text's share of the probability of all possible call numbers, times the
    geometric mean of the probabilities of its symbols.
    """

    text: str
    confidence: float


class CallNumberDecoder:
    """Decoder that finds the most likely call number `ddd[.d...] L...` in the outputs of a text recogniser
    (CTC).

    The method is prefix beam search, which keeps the most likely beginnings of the text at each step (Graves
    et al., "Connectionist temporal classification", 2006; Hannun et al., 2014). Here only beginnings of call
    numbers are kept. If the outputs allow no call number, there is no result.
    """

    def __init__(self, characters: Sequence[str], forms: Collection[tuple[int, int]] = USUAL_FORMS) -> None:
        """Create a decoder.

        Args:
            characters: character of each of the recogniser's output columns; column 0 is the blank.
            forms: allowed pairs of the number of digits after the decimal point, and the number of letters.
                Where both vary independently, "61 VU" can't be told from "6 IVU", as a 1 looks like an I.
        """
        columns = {character: i for i, character in enumerate(characters)}
        self._groups = [
            [columns[alias] for alias in _ALIASES.get(symbol, symbol) if alias in columns]
            for symbol in CALL_NUMBER_SYMBOLS
        ]
        self._blank = [0] + [columns[c] for c in (" ", "\u3000") if c in columns]
        self._forms = frozenset(forms)
        self._max_decimals, self._max_letters = (max(counts) for counts in zip(*self._forms, strict=True))

    def decode(self, probabilities: SingleArray) -> Decoded | None:
        """Return the likeliest call number, or None if no valid call number is likely enough.

        Args:
            probabilities: (t, n) probability, 0 to 1, of each of n characters at each of t steps along the
                text; column 0 is the blank, CTC's symbol for no character.
        """
        symbols = np.column_stack([probabilities[:, group].sum(axis=1) for group in self._groups])
        blanks = probabilities[:, self._blank].sum(axis=1)
        # For each prefix: its probability ending in a blank, and ending in its last symbol.
        beams: dict[tuple[int, ...], tuple[float, float]] = {(): (1.0, 0.0)}
        for row, blank in zip(symbols.astype(np.float64), blanks.tolist(), strict=True):
            beams = self._step(beams, row, blank)
        finished = {prefix: sum(p) for prefix, p in beams.items() if self._finished(prefix)}
        if not finished:
            return None
        best = max(finished, key=lambda prefix: (finished[prefix], prefix))
        text = "".join(CALL_NUMBER_SYMBOLS[i] for i in best)
        quality = min(1.0, finished[best]) ** (1.0 / len(best))
        confidence = finished[best] / sum(finished.values()) * quality
        number = text.rstrip(CALL_NUMBER_SYMBOLS[_LETTERS.start :])
        return Decoded(f"{number} {text[len(number) :]}", float(confidence))

    def _step(
        self, beams: dict[tuple[int, ...], tuple[float, float]], row: FloatArray, blank: float
    ) -> dict[tuple[int, ...], tuple[float, float]]:
        grown: dict[tuple[int, ...], tuple[float, float]] = {}
        likely = [(int(i), float(row[i])) for i in np.flatnonzero(row > _UNLIKELY)]
        for prefix, (ends_blank, ends_symbol) in beams.items():
            last = prefix[-1] if prefix else -1
            stays = float(row[last]) * ends_symbol if prefix else 0.0
            _add(grown, prefix, (ends_blank + ends_symbol) * blank, stays)
            for i, p in likely:
                if self._may_follow(prefix, i):
                    # A symbol twice in a row needs a blank between, or it is one symbol.
                    _add(
                        grown, (*prefix, i), 0.0, p * (ends_blank if i == last else ends_blank + ends_symbol)
                    )
        best = sorted(grown.items(), key=lambda item: (-sum(item[1]), item[0]))
        return dict(best[:_BEAM])

    def _may_follow(self, prefix: tuple[int, ...], symbol: int) -> bool:
        letters = sum(i in _LETTERS for i in prefix)
        digits = len(prefix) - letters
        if letters or symbol in _LETTERS:
            complete = digits == 3 or (digits > 4 and prefix[3] == _POINT)
            return symbol in _LETTERS and complete and letters < self._max_letters
        if len(prefix) < 3:
            return symbol in _DIGITS
        return symbol == _POINT if len(prefix) == 3 else symbol in _DIGITS and digits < 4 + self._max_decimals

    def _finished(self, prefix: tuple[int, ...]) -> bool:
        letters = sum(symbol in _LETTERS for symbol in prefix)
        return (max(0, len(prefix) - letters - 4), letters) in self._forms


def _add(
    beams: dict[tuple[int, ...], tuple[float, float]], prefix: tuple[int, ...], blank: float, symbol: float
) -> None:
    if blank + symbol > 0.0:
        before = beams.get(prefix, (0.0, 0.0))
        beams[prefix] = (before[0] + blank, before[1] + symbol)
