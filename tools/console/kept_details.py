"""Details of runs, cached until something new is in their folders: many pages request the same ones."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import orjson

from handcart.networks.operator.view_address import ADDRESS_FILE as ADDRESS

from .run_details import EVIDENCE_PATH, RUN_PAGES, RunDetails

MAX_KEPT_RUNS = 32
Away = Callable[[Callable[[], Any]], Awaitable[Any]]


class KeptDetails:
    """Cache of the details of the runs requested last, as JSON that is ready to be sent."""

    def __init__(self) -> None:
        """Create an empty cache."""
        self._kept: dict[Path, tuple[object, asyncio.Future[Any]]] = {}

    async def of(self, folder: Path, alive: bool, situation: str | None, away: Away) -> Any:
        """Return a run's details as JSON; they are read only once for all clients that request them.

        Args:
            folder: the run's folder.
            alive: True while the run is running.
            situation: the situation of the network that the run itself reports; None if it reports none.
            away: function that runs slow work outside the event loop; if reading fails, the error response
                that this function returns is passed on.
        """
        written = ("journal.jsonl", EVIDENCE_PATH, ADDRESS, *RUN_PAGES)
        mark = alive, situation, *(_mark(folder / name) for name in written)
        known = self._kept.get(folder)
        if known is None or known[0] != mark:
            reading = asyncio.ensure_future(
                away(lambda: orjson.dumps(RunDetails(folder, alive).summary(situation)))
            )
            self._kept.pop(folder, None)
            self._kept[folder] = known = mark, reading
            if len(self._kept) > MAX_KEPT_RUNS:
                del self._kept[next(iter(self._kept))]
        return await asyncio.shield(known[1])


def _mark(path: Path) -> tuple[int, int]:
    try:
        status = path.stat()
    except OSError:
        return 0, 0
    return status.st_mtime_ns, status.st_size
