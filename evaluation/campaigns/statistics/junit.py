"""Report of a campaign in JUnit XML, which CI servers display."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from xml.etree.ElementTree import Element, ElementTree, SubElement, indent

from handcart.evaluation.campaigns.data.trial import Trial

from .claim import Settling


def write_junit(path: Path, name: str, trials: Iterable[Trial], settling: Settling | None) -> None:
    """Write a JUnit file with a test case for each trial, and one for a claim about the success rate.

    A false outcome is a failure. A trial that does not reach the goal is a failure only without a claim,
    because a claim allows a share of the trials to miss the goal.

    Raises:
        OSError: the file cannot be written.
    """
    suite = Element("testsuite", name=name)
    counts = {"tests": 0, "failures": 0, "errors": 0}
    for trial in trials:
        case = _case(suite, counts, name, f"seed {trial.seed}")
        case.set("time", f"{trial.summary['sim_time_s']:.3f}")
        words = trial.summary["reason"]
        if trial.untrue:
            _add(case, counts, "failures", "; ".join(trial.untrue))
        elif trial.status == 5:
            _add(case, counts, "errors", words)
        elif not trial.success and settling is None:
            _add(case, counts, "failures", f"{trial.summary['outcome']}: {words}")
        elif not trial.success:
            SubElement(case, "system-out").text = _plain(f"{trial.summary['outcome']}: {words}")
    if settling is not None:
        case = _case(suite, counts, name, str(settling.claim))
        if not settling.verdict:
            _add(case, counts, "failures", settling.words())
    for key, count in counts.items():
        suite.set(key, str(count))
    indent(suite)
    ElementTree(suite).write(path, encoding="utf-8", xml_declaration=True)


def _case(suite: Element, counts: dict[str, int], group: str, name: str) -> Element:
    counts["tests"] += 1
    return SubElement(suite, "testcase", classname=group, name=name)


def _add(case: Element, counts: dict[str, int], kind: str, words: str) -> None:
    counts[kind] += 1
    SubElement(case, kind.removesuffix("s"), message=_plain(words))


def _plain(words: str) -> str:
    """Return a text without the characters that XML forbids."""
    return "".join(word if word.isprintable() else " " for word in words)
