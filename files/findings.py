"""Collector of findings, which reports all of them at once."""

from collections.abc import Iterable

from handcart.files.errors import FileError, Finding


class Findings:
    """Growing list of findings, which are raised together as one `FileError`.

    findings = Findings()
    if unknown:
        findings.add(document.finding(("network", "goal"), "unknown situation; allowed: ..."))
    findings.raise_all()
    """

    def __init__(self, findings: Iterable[Finding] = ()) -> None:
        self._findings = list(findings)

    def add(self, *findings: Finding) -> None:
        """Add findings to those collected so far."""
        self._findings.extend(findings)

    def take(self, error: FileError) -> None:
        """Add all findings of a `FileError` that a check raised, so that later checks can still run."""
        self._findings.extend(error.findings)

    def __bool__(self) -> bool:
        return bool(self._findings)

    def __len__(self) -> int:
        return len(self._findings)

    def raise_all(self) -> None:
        """Raise `FileError` with all findings collected so far, if there are any."""
        if self._findings:
            raise FileError(self._findings)
