"""The command `handcart`: every error is reported in words.

The module imports nothing but `sys` at its top, so that a Ctrl-C during any other import is caught.
"""

from __future__ import annotations

import sys

TYPE_CHECKING = False  # importing `typing` takes as long as all the rest of this module
if TYPE_CHECKING:
    from handcart.files.errors import InputError

INTERRUPTED_STATUS = 130


def main(arguments: list[str] | None = None) -> None:
    """Run the command line, and exit with its status (see the README); errors in the input are printed as
    messages.

    Problems of stdout never change the status: if its output goes to a closed pipe or a full disk, a run that
    ended in Success still has the status of Success. Lost output is reported on stderr.
    """
    try:
        status = _run_with_streams(arguments)
    except KeyboardInterrupt:
        status = INTERRUPTED_STATUS
    sys.exit(status)


def _run_with_streams(arguments: list[str] | None) -> int:
    from handcart.tools.terminal.streams import Streams

    if arguments is None:
        from handcart.tools.terminal.libraries import quiet_libraries

        quiet_libraries()
    words = sys.argv[1:] if arguments is None else arguments
    with Streams() as streams:
        status = _run(words)
    lost = streams.lost
    if lost:
        print(f"stdout can't be written: {lost}; its text is lost, the exit status holds", file=sys.stderr)
    return status


def _run(words: list[str]) -> int:
    from handcart.tools.terminal.libraries import NoLibrary, check_libraries

    try:
        _check_text(words)
        check_libraries()
        from .command_line import app

        app(words, standalone_mode=True)
    except SystemExit as end:
        return _status(end)
    except KeyboardInterrupt:
        return INTERRUPTED_STATUS
    except Exception as error:
        return _report_error(NoLibrary.of(error) or error)
    return 0


def _status(end: SystemExit) -> int:
    if end.code is None or isinstance(end.code, int):
        return end.code or 0
    print(end.code, file=sys.stderr)
    return 1


def _check_text(words: list[str]) -> None:
    """Raise InputError if an argument is not valid text, so that it could not be written into a file."""
    for word in words:
        try:
            word.encode()
        except UnicodeEncodeError:
            raise _not_text(word) from None


def _not_text(word: str) -> InputError:
    from handcart.files.errors import InputError

    shown = word.encode(errors="backslashreplace").decode()
    return InputError(f"the word {shown} is not UTF-8; allowed: names of files in UTF-8")


def _report_error(error: Exception) -> int:
    """Print an error in words, a fault of our own with its traceback too, and return the exit status."""
    from handcart.files.errors import HandcartError
    from handcart.files.printable import printable

    if isinstance(error, HandcartError):
        print("\n".join(map(printable, str(error).split("\n"))), file=sys.stderr)
        return error.exit_status
    import traceback

    traceback.print_exception(error)
    print("this is a fault in handcart, not in what you gave it", file=sys.stderr)
    return 5


if __name__ == "__main__":
    main()
