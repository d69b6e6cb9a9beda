"""Periodic observation of all runs in a folder."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import Any

from handcart.files.errors import HandcartError
from handcart.networks.operator.asking import NotAnswering, ask
from handcart.networks.run_files.run_names import ListedRun, list_runs
from handcart.networks.run_files.socket_path import CONTROL_SOCKET

from .run_details import RUN_PAGES

LOOKS_S = 0.2
"""Time between two looks at running runs, in [s]."""
LOOKS_PER_LISTING = 5
"""Number of looks at running runs between two listings of the folder."""
MAX_SHOWN_RUNS = 200
"""Maximum number of runs shown, the newest ones; older ones are shown as well while they may be running."""
PATIENCE_S = 1.0
"""Time that a run has to answer the watcher, in [s]."""


class Watcher:
    """Observer of the runs in a folder and their states, which notifies waiting clients of each change."""

    def __init__(self, runs: Path) -> None:
        """Watch a folder, which may not exist yet."""
        self.folder = runs
        self._pool = ThreadPoolExecutor(4, thread_name_prefix="console")
        self._listed: dict[str, ListedRun] = {}
        self._live: dict[str, dict[str, Any]] = {}
        self._over: dict[str, tuple[int, int]] = {}
        self._version = 0
        self._changed = asyncio.Condition()

    async def watch(self) -> None:
        """Look for changes of the folder's runs every `LOOKS_S` seconds, and notify the clients, until
        cancelled.
        """
        count = 0
        while True:
            before = self.states()
            if count % LOOKS_PER_LISTING == 0:
                self._listed = await self.away(self._list)
            await asyncio.gather(*(self._look(name) for name in self._listed))
            count += 1
            if self.states() != before:
                await self.tell_all()
            await asyncio.sleep(LOOKS_S)

    async def away(self, work: Any, *words: Any) -> Any:
        """Run a slow function in a thread, so that it does not stop the server's event loop, and return its
        result.
        """
        return await asyncio.get_running_loop().run_in_executor(self._pool, work, *words)

    async def tell_all(self) -> None:
        """Notify all waiting clients that the state of a run has changed."""
        async with self._changed:
            self._version += 1
            self._changed.notify_all()

    async def newer(self, version: int, patience: float) -> int:
        """Wait until the runs' states have changed since `version`, and return the number of their present
        version.

        Args:
            version: version that the client has.
            patience: longest time to wait, in [s].
        """
        async with self._changed:
            with suppress(TimeoutError):
                await asyncio.wait_for(self._changed.wait_for(lambda: self._version > version), patience)
            return self._version

    def folder_of(self, name: str) -> Path | None:
        """Return a run's folder by its name; None if no listed run has exactly this name.

        See row U14 of docs/reference/faults.md.
        """
        listed = self._listed.get(name)
        return None if listed is None else listed.folder

    def alive(self, name: str) -> bool:
        """Return whether a program is executing the run with this name, by its last answer to a query."""
        return name in self._live

    async def look_now(self, name: str) -> None:
        """Read the state of a run again, and notify all clients."""
        await self._look(name)
        await self.tell_all()

    def states(self) -> list[dict[str, Any]]:
        """Return the states of all runs, the newest first."""
        return [self._state(name, listed) for name, listed in self._listed.items()]

    def close(self) -> None:
        """Stop the threads in which slow functions are called; calls that have not begun are cancelled."""
        self._pool.shutdown(wait=False, cancel_futures=True)

    def _list(self) -> dict[str, ListedRun]:
        runs = list_runs(self.folder)
        older = (run for run in runs[MAX_SHOWN_RUNS:] if (run.folder / CONTROL_SOCKET).exists())
        return {run.folder.name: run for run in (*runs[:MAX_SHOWN_RUNS], *older)}

    async def _look(self, name: str) -> None:
        """Ask a run that may be alive for its status, and note it.

        A run whose socket was left behind is asked only once.
        """
        folder = self._listed[name].folder
        try:
            status = (folder / CONTROL_SOCKET).stat()
        except OSError:
            self._live.pop(name, None)
            return
        mark = status.st_ino, status.st_mtime_ns
        if self._over.get(name) == mark:
            return
        try:
            self._live[name] = await self.away(ask, folder, {"do": "status"}, PATIENCE_S)
        except NotAnswering as error:
            self._live[name] = {"state": "doesn't answer", "error": str(error)}
        except HandcartError:
            self._over[name] = mark
            self._live.pop(name, None)

    def _state(self, name: str, listed: ListedRun) -> dict[str, Any]:
        live: Mapping[str, Any] | None = self._live.get(name)
        head = {
            "name": name,
            "task": listed.task,
            "seed": listed.seed,
            "backend": listed.backend,
            "begun": listed.begun,
            "alive": live is not None,
        }
        if live is None:
            pages = [page for page in RUN_PAGES if (listed.folder / page).is_file()]  # written after the end
            return {**head, "state": listed.outcome or "broken off", "pages": pages}
        rest = {key: value for key, value in live.items() if key != "ok"}
        return {**head, **rest}
