"""Test whether a Dask scheduler answers at an address, before the library is used."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import orjson

from handcart.files.errors import InputError
from handcart.files.printable import clipped, printable
from handcart.files.regular_file import open_regular

MAX_FILE = 2**20  # of a scheduler's file [bytes]


class NoCluster(InputError):
    """Error for a cluster without an available scheduler or worker; no trial has been run."""


class NoScheduler(NoCluster):
    """Error for an address at which no program answers, or a program that is not a Dask scheduler."""

    def __init__(self, address: str, wrong: str) -> None:
        allowed = "allowed: the address of a Dask scheduler, such as tcp://10.0.0.1:8786"
        super().__init__(printable(f"--cluster {address}: {wrong}; {allowed}"))


def check_scheduler(address: str, timeout: float) -> None:
    """Ask the program at an address to identify itself as a Dask scheduler, with a time-out.

    Dask's own client would retry for ever if another program accepted its connections.

    Args:
        address: such as `tcp://10.0.0.1:8786`, or the path of a scheduler's file.
        timeout: time-out of the answer, in [s].

    Raises:
        NoScheduler: nothing, or another kind of program, answers within that time.
    """
    try:
        said = asyncio.run(asyncio.wait_for(_identity(_address_in(address), timeout), timeout))
    except TimeoutError:
        raise NoScheduler(address, f"no scheduler answers within {timeout:g} s") from None
    except Exception as error:  # a foreign server may send anything
        words = clipped(f"{type(error).__name__}: {error}".split("\n")[0])
        raise NoScheduler(address, f"no scheduler answers: {words}") from None
    kind = said.get("type") if isinstance(said, dict) else None
    if kind != "Scheduler":
        raise NoScheduler(address, f"the answer is not that of a scheduler: {clipped(repr(kind or said))}")


def _address_in(address: str) -> str:
    if "://" in address:
        return address
    with open_regular(Path(address)) as file:
        return str(orjson.loads(file.read(MAX_FILE))["address"])


async def _identity(address: str, timeout: float) -> Any:
    from distributed.comm import core
    from distributed.security import Security

    security: Any = Security
    connect: Any = core.connect
    comm = await connect(address, timeout=timeout, **security().get_connection_args("client"))
    try:
        await comm.write({"op": "identity", "reply": True})
        return await comm.read()
    finally:
        comm.abort()
