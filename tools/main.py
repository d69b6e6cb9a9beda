"""The command `handcart`: every error is reported in words."""

from __future__ import annotations

import sys

from handcart.files.errors import HandcartError, InputError
from handcart.tools.terminal.libraries import NoLibrary, check_libraries, quiet_libraries
from handcart.tools.terminal.streams import Streams


class NotText(InputError):
    """Error of a command-line argument that is not valid text, so that it could not be written into a
    file.
    """


def main(arguments: list[str] | None = None) -> None:
    """Run the command line, and exit with its status (see the README); errors in the input are printed as
    messages.

    Problems of stdout never change the status: if its output goes to a closed pipe or a full disk, a run that
    ended in Success still has the status of Success. Lost output is reported on stderr.
    """
    if arguments is None:
        quiet_libraries()
    words = sys.argv[1:] if arguments is None else arguments
    with Streams() as streams:
        status = _run(words)
    lost = streams.lost
    if lost:
        print(f"stdout can't be written: {lost}; its text is lost, the exit status holds", file=sys.stderr)
    sys.exit(status)


def _run(words: list[str]) -> int:
    try:
        _check_text(words)
        check_libraries()
        from .command_line import app

        app(words, standalone_mode=True)
    except SystemExit as end:
        return _status(end)
    except KeyboardInterrupt:
        return 130
    except Exception as error:
        return _report_error(NoLibrary.of(error) or error)
    return 0


def _status(end: SystemExit) -> int:
    if end.code is None or isinstance(end.code, int):
        return end.code or 0
    print(end.code, file=sys.stderr)
    return 1


def _check_text(words: list[str]) -> None:
    for word in words:
        try:
            word.encode()
        except UnicodeEncodeError:
            shown = word.encode(errors="backslashreplace").decode()
            raise NotText(f"the word {shown} is not UTF-8; allowed: names of files in UTF-8") from None


def _report_error(error: Exception) -> int:
    """Print an error in words, a fault of our own with its traceback too, and return the exit status."""
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
