"""The person who brings a robot up."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from typing import Any

from typing_extensions import override

from handcart.files.errors import InputError

Held = Callable[[], bool]
"""Function that returns whether the key is still held; once False, it stays False."""


class UnansweredQuestion(InputError):
    """Error for a question of a bring-up step that the operator did not answer."""


class Operator(ABC):
    """Interface of a person or script that reads messages and answers questions during a bring-up.

    Each answer is recorded under the question's key.
    """

    @abstractmethod
    def tell(self, words: str) -> None:
        """Show a message to the operator."""

    @abstractmethod
    def confirm(self, key: str, question: str) -> bool:
        """Ask the operator a question, and return True for yes; `key` identifies the question in records."""

    @abstractmethod
    def number(self, key: str, question: str, truth: Callable[[], float]) -> float:
        """Return a value that the operator measured, in the unit of the question.

        Args:
            key: identifies the question in records.
            question: text of the question.
            truth: returns the true value; with simulated drives (a bench) it is the answer.
        """

    @abstractmethod
    def act(self, key: str, words: str, on_bench: Callable[[], None]) -> None:
        """Ask the operator to do something by hand at once.

        Args:
            key: identifies the request.
            words: text of the request.
            on_bench: function that simulates the action on a bench, where no person acts.
        """

    @abstractmethod
    def hold(self, words: str) -> AbstractContextManager[Held]:
        """Ask the operator to hold a key; return a context in which the robot moves while the key is held."""


class BenchOperator(Operator):
    """Automatic operator of a bench (simulated drives) that confirms everything and measures true values."""

    def __init__(self, say: Callable[[str], None] = lambda _: None) -> None:
        self._say = say

    @override
    def tell(self, words: str) -> None:
        self._say(words)

    @override
    def confirm(self, key: str, question: str) -> bool:
        self._say(f"{question} yes (bench)")
        return True

    @override
    def number(self, key: str, question: str, truth: Callable[[], float]) -> float:
        measured = truth()
        self._say(f"{question} {measured:.4g} (bench)")
        return measured

    @override
    def act(self, key: str, words: str, on_bench: Callable[[], None]) -> None:
        self._say(f"{words} (bench)")
        on_bench()

    @override
    def hold(self, words: str) -> AbstractContextManager[Held]:
        self._say(f"{words} (bench)")
        return nullcontext(lambda: True)


class ScriptedOperator(BenchOperator):
    """Operator for tests that answers each question from a file by the question's key."""

    def __init__(self, answers: Mapping[str, Any], say: Callable[[str], None] = lambda _: None) -> None:
        """Take the answers by key of the question, each true, false or a number; `say` shows messages."""
        super().__init__(say)
        self._answers = answers

    def confirm(self, key: str, question: str) -> bool:
        """Return True if the file of answers says yes to a question, False if it says no.

        Raises:
            UnansweredQuestion: the file has no answer, yes or no, for this key.
        """
        return bool(self._answer(key, question, bool))

    def number(self, key: str, question: str, truth: Callable[[], float]) -> float:
        """Return the number that the file of answers has for a question; `truth` is not used.

        Raises:
            UnansweredQuestion: the file has no number for this key.
        """
        return float(self._answer(key, question, (int, float)))

    def _answer(self, key: str, question: str, kind: Any) -> Any:
        given = self._answers.get(key)
        if given is None or not isinstance(given, kind):
            allowed = "true or false" if kind is bool else "a number"
            raise UnansweredQuestion(f"no answer to {key!r} ({question}); needed: {allowed}")
        self._say(f"{question} {given}")
        return given
