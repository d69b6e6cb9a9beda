"""A campaign as JUnit XML, which CI servers show."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from xml.etree.ElementTree import Element, ElementTree, SubElement, indent

from handcart.evaluation.campaigns.data.trial import Trial

from .claim import Settling


def write_junit(path: Path, name: str, trials: Iterable[Trial], settling: Settling | None) -> None:
    """A test case for each trial, and one for a claim.

    An untrue outcome is a failure. A trial that doesn't reach the goal is one only where nothing is claimed
    of the success rate: else the claim says how many may.

    Raises:
        OSError: it can't be written.
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
            SubElement(case, "system-out").text = f"{trial.summary['outcome']}: {words}"
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
    """Without the characters that no XML may hold."""
    return "".join(each if each.isprintable() else " " for each in words)
