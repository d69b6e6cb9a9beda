"""Requests of the page, and their answers."""

from __future__ import annotations

import asyncio
import mimetypes
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import orjson
from aiohttp import web

from handcart.files.errors import HandcartError
from handcart.files.printable import clipped, printable
from handcart.networks.operator.acknowledging import acknowledge
from handcart.networks.operator.asking import ask, tell_to_stop
from handcart.networks.operator.message import COMMAND_WORDS, LONGEST_WORD
from handcart.networks.run_files.run_folder import read_file

from .guard import TICKETS_PATH, said
from .kept_details import KeptDetails
from .lease import Lease
from .run_details import EVIDENCE_PATH, EVIDENCE_SUFFIXES, RUN_PAGES, RunDetails
from .tickets import Tickets
from .watcher import Watcher

MOST_BODY = 16_384  # of a command, in [bytes]
PATIENCE_S = 5.0  # [s] for a command's body
BEAT_S = 2.0  # [s] after which listeners get a message, even if nothing is new
MOST_FILE = 64 * 2**20
TAB_HEADER = "X-Console-Tab"
"""Header with the unique identifier of the open page that sends the request."""
SANDBOX_POLICY = (
    "sandbox allow-scripts; default-src 'none'; img-src data:; style-src 'unsafe-inline'; "
    "script-src 'unsafe-inline'"
)
"""Content policy of a run's own page, which can load nothing and has no access to the console."""


class Handlers:
    """Handlers of the requests that the console's web page sends to the server."""

    def __init__(self, watcher: Watcher) -> None:
        """Handle requests about the runs that `watcher` observes."""
        self._watcher, self._lease, self._tickets = watcher, Lease(), Tickets()
        self._details = KeptDetails()

    def routes(self) -> list[web.RouteDef]:
        """Return the routes of the web application, each with its handler."""
        return [
            web.get("/api/events", self.events),
            web.get("/api/runs/{run}", self.run),
            web.get("/api/runs/{run}/files/{file:.+}", self.file),
            web.get("/api/runs/{run}/after/{action}", self.after),
            web.get("/api/runs/{run}/why/{number:[0-9]{1,9}}", self.why),
            web.post("/api/runs/{run}/command", self.command),
            web.post("/api/runs/{run}/stop", self.stop),
            web.post("/api/runs/{run}/acknowledge", self.acknowledge),
            web.post("/api/runs/{run}/ticket", self.ticket),
            web.post("/api/lease", self.lease),
            web.get(TICKETS_PATH + "{word}", self.page),
        ]

    async def events(self, request: web.Request) -> web.StreamResponse:
        """Stream lines of JSON with the states of all runs and the holder of the right to command them.

        The first line is sent at once, and another one after each change or after `BEAT_S` seconds without a
        change.
        """
        tab = _tab(request)
        answer = web.StreamResponse(headers={"Content-Type": "application/x-ndjson"})
        await answer.prepare(request)
        self._lease.connected(tab)
        version = -1
        try:
            while True:
                version = await self._watcher.newer(version, 0.0 if version < 0 else BEAT_S)
                state = {"runs": self._watcher.states(), "lease": self._lease.holder()}
                await answer.write(orjson.dumps(state) + b"\n")
        except (ConnectionResetError, asyncio.CancelledError):
            return answer
        finally:
            self._lease.gone(tab)

    async def run(self, request: web.Request) -> web.Response:
        """Send the browser the details of the run that the request names, as JSON."""
        name = request.match_info["run"]
        folder = self._folder(request)
        state: Mapping[str, Any] = next(item for item in self._watcher.states() if item["name"] == name)
        details = await self._details.of(folder, state["alive"], state.get("situation"), self._away)
        if isinstance(details, web.Response):
            return said(details.status, orjson.loads(details.text or "{}")["error"])
        return web.Response(body=details, content_type="application/json")

    async def after(self, request: web.Request) -> web.Response:
        """Send the probabilities of reaching the goal after each possible answer of a person about an action.

        The action waits for permission; the person may permit it, report that it has succeeded already, or
        refuse it.
        """
        folder, action = self._folder(request), request.match_info["action"]
        state = next(item for item in self._watcher.states() if item["name"] == request.match_info["run"])
        asks = state.get("asks")
        if not asks or str(asks["index"]) != action:
            return said(409, "that action is not waiting for permission")
        found = await self._away(lambda: RunDetails(folder, True).after(state["situation"], asks["index"]))
        return found if isinstance(found, web.Response) else _json(found)

    async def why(self, request: web.Request) -> web.Response:
        """Send the reason why an action was chosen: its alternatives, with their probabilities of the goal
        and times.
        """
        folder, number = self._folder(request), int(request.match_info["number"])
        found = await self._away(lambda: RunDetails(folder, True).why(number))
        return found if isinstance(found, web.Response) else _json(found)

    async def file(self, request: web.Request) -> web.Response:
        """Answer a browser's request with the requested picture from the evidence of a run's actions."""
        folder, name = self._folder(request), request.match_info["file"]
        where, _, file = name.rpartition("/")
        if where != EVIDENCE_PATH or not file.endswith(EVIDENCE_SUFFIXES):
            return said(404, "unknown picture")
        content = await self._away(lambda: read_file(folder / EVIDENCE_PATH, file, MOST_FILE))
        kind = mimetypes.guess_type(file)[0] or "application/octet-stream"
        return content if isinstance(content, web.Response) else web.Response(body=content, content_type=kind)

    async def command(self, request: web.Request) -> web.Response:
        """Pass a command on to a run, if the requesting browser tab has the right to command."""
        folder, message = self._folder(request), await _body(request)
        if not self._lease.holds(_tab(request)):
            return said(423, f"{self._lease.holder()['name'] or 'nobody'} commands; take the command first")
        if message.get("do") not in COMMAND_WORDS:
            return said(400, f"unknown command {printable(clipped(repr(message.get('do'))))}")
        many = message.pop("places", None)
        named = {**message, "by": self._lease.holder()["name"]}
        if many is None:
            reply = await self._away(lambda: ask(folder, named))
        else:
            reply = await self._away(lambda: _each(folder, named, many))
        await self._watcher.look_now(request.match_info["run"])
        if isinstance(reply, web.Response):
            return reply
        return _json(reply, 200 if reply["ok"] else 409)

    async def stop(self, request: web.Request) -> web.Response:
        """Stop a run at once; every client with access may do so, also without the right to command.

        See rows U8 and U9 of docs/reference/faults.md.
        """
        folder = self._folder(request)
        try:
            tell_to_stop(folder)
        except HandcartError as error:
            return said(409, str(error))
        return _json({"ok": True})

    async def acknowledge(self, request: web.Request) -> web.Response:
        """Acknowledge a GiveUp of a run, if the request names its record and cause as the operator has read
        them.

        See row U12 of docs/reference/faults.md.
        """
        folder, word = self._folder(request), await _body(request)
        if not self._lease.holds(_tab(request)):
            return said(423, f"{self._lease.holder()['name'] or 'nobody'} commands; take the command first")
        record, cause = word.get("record"), word.get("cause")
        if isinstance(record, bool) or not isinstance(record, int) or not isinstance(cause, str) or not cause:
            return said(400, "record and cause are missing; needed: those that were shown")
        reason = await self._away(lambda: acknowledge(folder, record, cause))
        return reason if isinstance(reason, web.Response) else _json({"ok": True, "reason": reason})

    async def lease(self, request: web.Request) -> web.Response:
        """Give the right to command the runs to the browser tab that asks for it, or release that right."""
        word, tab = await _body(request), _tab(request)
        name = word.get("name")
        if not tab:
            return said(400, f"the header {TAB_HEADER} is missing")
        if word.get("take") is not True:
            self._lease.release(tab)
        elif not isinstance(name, str) or not 0 < len(name.strip()) <= LONGEST_WORD:
            return said(400, "name is missing; needed: yours, so that others see who commands")
        else:
            self._lease.take(tab, printable(name.strip()))
        await self._watcher.tell_all()
        return _json({"ok": True, "lease": self._lease.holder()})

    async def ticket(self, request: web.Request) -> web.Response:
        """Send the address of a new ticket, with which one of the pages in a run's folder can be opened
        once.
        """
        folder, word = self._folder(request), await _body(request)
        if word.get("page") not in RUN_PAGES:
            return said(404, f"unknown page; allowed: {', '.join(RUN_PAGES)}")
        return _json({"ok": True, "url": TICKETS_PATH + self._tickets.give(folder, str(word["page"]))})

    async def page(self, request: web.Request) -> web.Response:
        """Answer with the file of a run that the ticket in the request's address permits to open once."""
        ticket = self._tickets.take(request.match_info["word"])
        if ticket is None:
            return said(403, "this address was valid once, within half a minute; the console opens it again")
        content = await self._away(lambda: read_file(ticket.folder, ticket.name, MOST_FILE))
        if isinstance(content, web.Response):
            return content
        headers = {"Content-Security-Policy": SANDBOX_POLICY}
        return web.Response(body=content, content_type="text/html", charset="utf-8", headers=headers)

    def _folder(self, request: web.Request) -> Path:
        folder = self._watcher.folder_of(request.match_info["run"])
        if folder is None:
            raise web.HTTPNotFound(reason="there is no such run")
        return folder

    async def _away(self, work: Any) -> Any:
        """Run slow work in a thread, and return its result; an error of it becomes an answer in words."""
        try:
            return await self._watcher.away(work)
        except HandcartError as error:
            return said(409, str(error))
        except (OSError, LookupError, TypeError, ValueError) as error:
            return said(409, f"the run's folder can't be read: {type(error).__name__}: {error}")


def _each(folder: Path, message: dict[str, Any], places: object) -> dict[str, Any]:
    """Send a message to a run once for each situation that a box of the drawing stands for; return the last
    reply.
    """
    if not isinstance(places, list) or not places or not all(isinstance(item, str) for item in places):
        return {"ok": False, "error": "places is not a list of situations"}
    reply: dict[str, Any] = {}
    for number, place in enumerate(places):
        nonce = f"{str(message.get('nonce', ''))[: LONGEST_WORD - 8]}.{number}"
        reply = ask(folder, {**message, "at": place, "nonce": nonce})
        if not reply["ok"]:
            break
    return reply


def _tab(request: web.Request) -> str:
    """Return the identifier of the page that sends a request; empty without one."""
    tab = request.headers.get(TAB_HEADER, "")
    if len(tab) > LONGEST_WORD or not (tab.isascii() and tab.isprintable()):
        raise web.HTTPBadRequest(reason=f"the header {TAB_HEADER} is too long, or no plain text")
    return tab


async def _body(request: web.Request) -> dict[str, Any]:
    try:
        content = await asyncio.wait_for(request.read(), PATIENCE_S)
        word = orjson.loads(content)
    except TimeoutError:
        raise web.HTTPRequestTimeout(reason="the command arrived incomplete, or too slowly") from None
    except orjson.JSONDecodeError:
        word = None
    if not isinstance(word, dict):
        raise web.HTTPBadRequest(reason="this is not a JSON object")
    return word


def _json(content: Any, status: int = 200) -> web.Response:
    return web.Response(body=orjson.dumps(content), status=status, content_type="application/json")
