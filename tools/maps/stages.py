"""Progress of a long computation in stages."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def stages_shown() -> Iterator[Callable[[str, float], None]]:
    """Yield a function to call with the name of the present stage and its finished share, 0 to 1.

    If stderr is a terminal, the function shows a progress bar for each stage, which is removed at the end.
    Otherwise it prints a line for each stage.
    """
    if not sys.stderr.isatty():
        yield _lines()
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("", total=1.0)
        yield lambda stage, share: progress.update(task, description=stage, completed=share)


def _lines() -> Callable[[str, float], None]:
    said = set[str]()

    def heard(stage: str, share: float) -> None:
        if stage not in said:
            said.add(stage)
            print(f"{stage} ...", file=sys.stderr, flush=True)

    return heard
