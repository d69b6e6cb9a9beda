"""Constructs that are lost from trees and state machines, found in their text alone."""

from __future__ import annotations

import re
from collections.abc import Iterator

from .foreign_trees import LOST_KEYS

LOST_TAGS = re.compile(
    r"(Rate|Distance|Speed)Controller|PipelineSequence|Reactive\w+|RoundRobin|GoalUpdater|GoalUpdatedController"
    r"|PathLongerOnApproach|SingleTrigger|Parallel(All)?|KeepRunningUntilFailure|Script(Condition)?|SetBlackboard"
    r"|Switch\d|WhileDoElse|Delay|RunOnce|SequenceStar|SequenceWithMemory"
)
TAG_PATTERN = re.compile(r"<(\w+)([^<>]*?)(/?)>", re.S)
PORT_PATTERN = re.compile(r'(\w+)\s*=\s*"\{([^"]*)\}"')
COMMENT_PATTERN = re.compile(r"<!--.*?-->", re.S)


def lost_in_tree(text: str) -> Iterator[tuple[int, str]]:
    """Yield line and word of each construct of a tree that a task cannot express."""
    plain = COMMENT_PATTERN.sub(lambda comment: "\n" * comment[0].count("\n"), text)
    top = next(iter(re.findall(r"<BehaviorTree[^>]*>\s*<(\w+)", plain)), "")
    subtrees = re.findall(r"<SubTree[^>]*>", plain)
    passed = {name for subtree in subtrees for name in re.findall(r'(\w+)="[^{"]', subtree)}
    for tag in TAG_PATTERN.finditer(plain):
        line, name = plain.count("\n", 0, tag.start()) + 1, tag[1]
        is_rounds = name == top == "KeepRunningUntilFailure"  # the whole tree, again and again
        if LOST_TAGS.fullmatch(name) and not is_rounds:
            yield line, name
        if tag[3] and name not in ("SubTree", "SubTreePlus", "input_port", "output_port", "inout_port"):
            yield from (
                (line, f"{port}=") for port, entry in PORT_PATTERN.findall(tag[2]) if entry not in passed
            )
        yield from ((line, word) for word in re.findall(r"(_(?:skipIf|while|onSuccess|onFailure))=", tag[2]))


def lost_in_machine(text: str) -> Iterator[tuple[int, str]]:
    """Yield line and key of each construct of a state machine that a task cannot express."""
    lines = text.splitlines()
    for number, line in enumerate(lines, start=1):
        key = line.strip().lstrip("- ").partition(":")[0]
        if key in LOST_KEYS:
            yield number, f"`{key}`"
        if "template: Concurrence" in line:
            yield number - 1, "concurrence"
        for word in ("preempted:", "NOT_THERE"):
            if word in line:
                yield _state_above(lines, number), word.rstrip(":")
        if "NOWHERE" in line:
            yield number, "`initial_state`"


def _state_above(lines: list[str], number: int) -> int:
    """Return the line of the state that a line belongs to."""
    while number > 1 and not re.fullmatch(r"\s*(- )?(?!transitions)\w+:\s*", lines[number - 1]):
        number -= 1
    return number
