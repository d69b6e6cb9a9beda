"""Count the files that run from `handcart run tasks/drive_map/task.yaml` to MOVE_TO's motion.

Counted are files of handcart of which a function is called, not bodies of modules and classes. With --list
they are printed. The number measures how much a reader has to follow.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import Counter
from contextlib import suppress
from inspect import CO_OPTIMIZED
from pathlib import Path
from types import FrameType

REPOSITORY_ROOT = Path(__file__).resolve().parents[1]


class There(BaseException):
    """The motion has begun."""


def files() -> list[str]:
    """Return the files that run on the way, relative to the checkout's root."""
    from handcart.primitives.driving.move_to import MoveTo
    from handcart.tools.main import main

    seen: set[str] = set()
    goal, top = MoveTo.motion.__code__, str(REPOSITORY_ROOT)

    def watch(frame: FrameType, event: str, _: object) -> None:
        code = frame.f_code
        if event == "call" and code.co_flags & CO_OPTIMIZED and code.co_filename.startswith(top):
            seen.add(code.co_filename)
            if code is goal:
                raise There

    with tempfile.TemporaryDirectory() as folder:
        sys.argv = [
            "handcart",
            "run",
            str(REPOSITORY_ROOT / "tasks" / "drive_map" / "task.yaml"),
            "--runs",
            folder,
        ]
        sys.setprofile(watch)
        try:
            with suppress(There):
                main()
        finally:
            sys.setprofile(None)
    inside = (Path(name).relative_to(REPOSITORY_ROOT) for name in seen if "site-packages" not in name)
    return sorted(str(pose2) for pose2 in inside if pose2.parts[0] not in ("benchmarks", ".venv"))


if __name__ == "__main__":
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("--list", action="store_true", help="print them")
    listed = words.parse_args().list
    found = files()
    if listed:
        print("\n".join(found))
    rooms = Counter(name.split("/")[0] for name in found)
    print(f"{len(found)} files: {', '.join(f'{room} {count}' for room, count in sorted(rooms.items()))}")
