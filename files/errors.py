"""Root of all errors of handcart, and the errors of files.

    HandcartError                    exit status 5
    └── InputError (ValueError)      exit status 2: refused before anything moved
        ├── FileError                all findings in a file at once
        └── UnsafePath               a path in a file leads out of its root

Other layers derive their own classes from `HandcartError` (or from `InputError` if input is bad).
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

from handcart.files.printable import printable
from handcart.files.shown_path import shown_path


class HandcartError(Exception):
    """Base class of all errors that handcart raises, for invalid input or a failed operation.

    A motion that ends as expected, even unsuccessfully, returns its outcome and raises none of them.
    """

    exit_status: ClassVar[int] = 5
    """Exit status of a command that this error ends."""


class InputError(HandcartError, ValueError):
    """Error in a user's input, found before anything moved."""

    exit_status: ClassVar[int] = 2


@dataclass(frozen=True, order=True)
class Finding:
    """Problem at one place of a file.

    `message` reads "what is wrong; what is allowed". `line` and `column` count from 1; line 0 means that
    `file` has no lines (`--set KEY=VALUE` on the command line).
    """

    file: str
    line: int
    column: int
    message: str

    def __str__(self) -> str:
        file = shown_path(self.file)
        place = f"{file}:{self.line}:{self.column}" if self.line else file
        return printable(f"{place}: {self.message}")


class FileError(InputError):
    """Error for a file that cannot be used, with all problems found in it, in the order of the lines."""

    def __init__(self, findings: Iterable[Finding]) -> None:
        self.findings: tuple[Finding, ...] = tuple(sorted(set(findings)))
        super().__init__("\n".join(str(finding) for finding in self.findings))

    def __reduce__(self) -> tuple[type["FileError"], tuple[tuple[Finding, ...]]]:
        # An exception is pickled with its message by default; process pools need the findings.
        return type(self), (self.findings,)


class UnsafePath(InputError):
    """Error for a path in a file that is absolute, leads out of its root folder, or is not portable."""

    def __init__(self, path: str, reason: str) -> None:
        self.path = path
        self.reason = reason
        super().__init__(printable(f"the path {path!r} {reason}; allowed: a relative path inside the root"))

    def __reduce__(self) -> tuple[type["UnsafePath"], tuple[str, str]]:
        return type(self), (self.path, self.reason)
