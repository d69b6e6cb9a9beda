"""Messages that a run accepts, and their checks."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from handcart.files.printable import clipped, printable
from handcart.networks.coordination.supervision import Request

Message = Mapping[str, Any]

REQUEST_BY_WORD = {
    "pause": Request.PAUSE,
    "continue": Request.RESUME,
    "stop": Request.STOP,
    "cancel": Request.CANCEL,
    "restore": Request.RESTORE,
}
COMMAND_WORDS = (*REQUEST_BY_WORD, "permit", "refuse", "step", "break", "status")
KEYS_BY_WORD: Mapping[str, Collection[str]] = {
    "pause": ("number",),
    "continue": ("number",),
    "cancel": ("number",),
    "restore": ("number",),
    "permit": ("action", "ask"),
    "refuse": ("action", "ask"),
    "step": ("on",),
    "break": ("at", "on"),
}
"""Keys that a command accepts in addition to `COMMON`.

`number`: of the action that is meant, as `status` gives it under `acting`; without it the run is meant, or
for `restore` the action that runs.
"""
COMMON_KEYS = ("do", "by", "nonce")
"""Keys of all messages. `by`: the sender; `nonce`: unique text, so that a repeated message acts once."""
LONGEST_WORD = 80


def fault_of(message: Message, situations: Collection[str]) -> str:
    """Return the fault of an invalid message, with the allowed values; empty if it is valid.

    A stop is valid whatever else it contains.
    """
    word = message.get("do")
    if word == "stop":
        return ""
    if not isinstance(word, str) or word not in COMMAND_WORDS:
        wrong = f"unknown word {shown(word)}" if "do" in message else "the key 'do' is missing"
        return f"{wrong}; allowed: {', '.join(COMMAND_WORDS)}"
    known = {*COMMON_KEYS, *KEYS_BY_WORD.get(word, ())}
    if unknown := message.keys() - known:
        return f"unknown key {shown(min(unknown))}; allowed: {', '.join(sorted(known))}"
    for key in ("action", "ask", "number"):
        number = message.get(key)
        if number is not None and (isinstance(number, bool) or not isinstance(number, int)):
            return f"{_NAMED[key]} {shown(number)} is not a number; allowed: {_NAMED[key]}'s number"
    for key in ("by", "nonce"):
        text = message.get(key, "")
        if not isinstance(text, str) or len(text) > LONGEST_WORD:
            return f"{key} is {shown(text)}; allowed: text of at most {LONGEST_WORD} letters"
    if not isinstance(message.get("on", True), bool):
        return f"on is {shown(message['on'])}; allowed: true, false"
    if word == "break" and message.get("at") not in situations:
        return f"at is {shown(message.get('at'))}; allowed: a situation of the task"
    return ""


_NAMED = {"action": "the action", "ask": "the question", "number": "the running action"}


def shown(value: object) -> str:
    """Return a value of a received message as text to print: shortened, control characters escaped."""
    return printable(clipped(repr(value)))
