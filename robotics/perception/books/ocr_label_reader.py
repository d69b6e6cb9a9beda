"""Labels read by a trained text recogniser (PP-OCR, as shipped inside the rapidocr wheel)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from handcart.robotics.numerics.arrays import ByteArray, SingleArray
from handcart.robotics.perception.books.call_number import CallNumber
from handcart.robotics.perception.books.call_number_decoder import (
    USUAL_DECIMALS,
    USUAL_FORMS,
    CallNumberDecoder,
)
from handcart.robotics.perception.books.label_reader import LabelReader, LabelReading

if TYPE_CHECKING:
    import onnxruntime

for _library in ("onnxruntime", "rapidocr"):  # reported at import, not when the first label is read
    if find_spec(_library) is None:
        raise ModuleNotFoundError(f"No module named {_library!r}", name=_library)

_STEP_PX = 8  # the recogniser gives one column of probabilities for this many of its input


class OcrLabelReader(LabelReader):
    """Label reader that uses the text recogniser of PP-OCR and decodes its outputs as call numbers only.

    The complete pipeline of the library rapidocr would also run a text detector, which takes four times as
    long, and would choose among 18,000 characters. Here only its recogniser is run, on `threads` threads of
    the processor. The model is loaded at the first reading, and shared by all readers.

    Call numbers are decoded with as many letters as those of the catalogue have; without a catalogue with 3.
    """

    def __init__(self, catalogue: Sequence[CallNumber] | None = None, threads: int = 1) -> None:
        super().__init__(catalogue)
        self._threads = threads

    def read_crops(self, crops: Sequence[ByteArray]) -> list[LabelReading]:
        """Return the text read on each of some crops (h, w), grey.

        Crops are read one after the other, because in a batch all of them would have to be as wide as the
        widest.
        """
        name = self._session.get_inputs()[0].name
        return [self._reading(self._session.run(None, {name: _input(crop)})[0][0]) for crop in crops]

    def _reading(self, probabilities: SingleArray) -> LabelReading:
        decoded = self._decoder.decode(probabilities)
        return LabelReading("", 0.0) if decoded is None else LabelReading(*decoded)

    @property
    def _session(self) -> onnxruntime.InferenceSession:
        return _session(self._threads)

    @cached_property
    def _decoder(self) -> CallNumberDecoder:
        known = self._session.get_modelmeta().custom_metadata_map["character"].splitlines()
        return CallNumberDecoder(["", *known, " "], _forms(self._catalogue or ()))


def _forms(catalogue: Sequence[CallNumber]) -> frozenset[tuple[int, int]]:
    """Return the numbers of decimals and letters that labels may have, by the call numbers of a catalogue.

    If all of them have equally many letters, other numbers of decimals are read as well.
    """
    forms = frozenset((len(number.decimals), len(number.letters)) for number in catalogue)
    letters = {letters for _, letters in forms}
    if len(letters) != 1:
        return forms or USUAL_FORMS
    decimals = max(USUAL_DECIMALS, *(decimals for decimals, _ in forms))
    return frozenset((count, max(letters)) for count in range(decimals + 1))


@lru_cache(maxsize=2)
def _session(threads: int) -> onnxruntime.InferenceSession:
    """Return the session that all readers of a process share: making it takes as long as reading a label."""
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    options.inter_op_num_threads = 1
    options.log_severity_level = 4
    return onnxruntime.InferenceSession(str(_model_file()), options, providers=["CPUExecutionProvider"])


def _model_file() -> Path:
    """Return the recogniser inside the installed rapidocr. Importing rapidocr itself would set up its
    loggers.
    """
    spec = find_spec("rapidocr")
    assert spec is not None
    assert spec.origin is not None
    models = sorted((Path(spec.origin).parent / "models").glob("*_rec_*.onnx"))
    if not models:
        raise FileNotFoundError(f"rapidocr at {spec.origin} carries no text recogniser")
    return models[-1]


def _input(crop: ByteArray) -> SingleArray:
    """Return a crop (48, w) as the recogniser wants it: (1, 3, 48, w), -1..1, padded with 0."""
    height, width = crop.shape
    result = np.zeros((1, 3, height, -(-width // _STEP_PX) * _STEP_PX), dtype=np.float32)
    darkest, brightest = float(crop.min()), float(crop.max())
    result[..., :width] = 2.0 * (crop.astype(np.float32) - darkest) / max(brightest - darkest, 1.0) - 1.0
    return result
