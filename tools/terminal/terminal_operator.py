"""The person at the terminal."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager

from typing_extensions import override

from handcart.evaluation.bringup.operator import Held, Operator, UnansweredQuestion

from .key_holding import held_key


class TerminalOperator(Operator):
    """Person at the terminal as operator of a procedure: questions go to stderr, answers are typed."""

    @override
    def tell(self, words: str) -> None:
        print(words, file=sys.stderr, flush=True)

    @override
    def confirm(self, key: str, question: str) -> bool:
        while True:
            said = self._line(key, f"{question} [y/n] ").lower()
            if said in ("y", "yes", "n", "no"):
                return said.startswith("y")

    @override
    def number(self, key: str, question: str, truth: Callable[[], float]) -> float:
        while True:
            try:
                given = float(self._line(key, f"{question} ").replace(",", "."))
            except ValueError:
                given = math.nan
            if math.isfinite(given):
                return given
            self.tell("a number, please, such as 0.103")

    @override
    def act(self, key: str, words: str, on_bench: Callable[[], None]) -> None:
        self.tell(words)
        on_bench()

    @override
    def hold(self, words: str) -> AbstractContextManager[Held]:
        self.tell(words)
        return held_key()

    def _line(self, key: str, prompt: str) -> str:
        print(prompt, end="", file=sys.stderr, flush=True)
        line = sys.stdin.readline()
        if not line:
            raise UnansweredQuestion(f"no answer to {key!r}: standard input has ended")
        return line.strip()
