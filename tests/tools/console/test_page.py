"""The console's page in a real browser, on a run of its own process."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from benchmarks.campaigns.walk import walk
from handcart.networks.drawing.network_picture import draw_network
from handcart.networks.drawing.svg import to_svg
from handcart.networks.graph.network import Action, ActionNetwork, Binding, Situation
from handcart.primitives.driving.modify import Modify
from handcart.tools.console.server import Server
from tests.browser import DESK, PHONE, Seen, axe_findings, browsing, needs_browser
from tests.tools.console.conftest import LIVE, OVER, LiveRun, Served

if TYPE_CHECKING:
    from playwright.sync_api import Page

pytestmark = [needs_browser, pytest.mark.slow]

PAYLOADS = (
    "<script>attacked=1</script>",
    "<img src=x onerror=attacked=1>",
    "<svg/onload=attacked=1>",
    '"><script>attacked=1</script>',
    "'><img src=x onerror=attacked=1>",
    "</text></svg><script>attacked=1</script>",
    "<iframe srcdoc='<script>top.attacked=1</script>'>",
    "<a href=javascript:attacked=1>x</a>",
    "javascript:attacked=1",
    "<body onload=attacked=1>",
    "<details open ontoggle=attacked=1>",
    "<input autofocus onfocus=attacked=1>",
    "<style>*{display:none}</style>",
    "<link rel=stylesheet href=//evil.example/x.css>",
    "<meta http-equiv=refresh content='0;url=//evil.example'>",
    "<base href=//evil.example/>",
    "<object data=//evil.example/x.swf>",
    "<embed src=//evil.example/x>",
    "<math><mtext></form><form><mglyph><style></math><img src onerror=attacked=1>",
    "<form action=//evil.example><button>x",
    "{{constructor.constructor('attacked=1')()}}",
    "${attacked=1}",
    "\\u003cscript\\u003eattacked=1\\u003c/script\\u003e",
    "&lt;script&gt;attacked=1&lt;/script&gt;",
    "<foreignObject><script>attacked=1</script></foreignObject>",
    "<animate onbegin=attacked=1 attributeName=x dur=1s>",
    "<use href=data:image/svg+xml,<svg id=x onload=attacked=1>#x>",
    "]]><script>attacked=1</script>",
    "--><script>attacked=1</script>",
    "<video><source onerror=attacked=1>",
)
"""Thirty, as names of things."""


@pytest.fixture(params=[PHONE, DESK], ids=["phone", "desk"])
def seen(request: pytest.FixtureRequest) -> Iterator[Seen]:
    with browsing(request.param) as opened:
        yield opened


def choose(page: Page, served: Served, run: str) -> None:
    page.goto(served.server.address)
    page.locator(f"[data-name={run}] button").click(timeout=20_000)


def command(page: Page) -> None:
    page.get_by_label("Your name").fill("Ada")
    page.get_by_role("button", name="Take the command").click()
    page.get_by_text("you command").wait_for(timeout=10_000)


def test_a_run_is_permitted_and_stopped(seen: Seen, served: Served, live: LiveRun) -> None:
    page = seen.page
    choose(page, served, LIVE)
    page.get_by_text("MOVE_TO from at_home to between").wait_for(timeout=20_000)
    page.get_by_text("P(goal): permitted 97.").wait_for(timeout=20_000)
    assert page.get_by_role("button", name="Permit").is_disabled()
    command(page)
    page.get_by_role("button", name="Permit").click()
    page.get_by_text("permit, by Ada").wait_for(timeout=20_000)
    assert [(message["do"], message["ask"], message["by"]) for message in live.heard] == [
        ("permit", 1, "Ada")
    ]
    page.get_by_role("button", name="STOP").click()
    page.wait_for_timeout(500)
    assert live.stops == 1
    assert "token" not in page.url
    assert seen.errors == []
    assert [
        request for request in seen.requests if not request.startswith((f"http://{served.host}", "blob:"))
    ] == []


def test_u7_a_double_click_permits_once(served: Served, live: LiveRun) -> None:
    """The question's number decides: the run itself refuses the second click."""
    with browsing(DESK) as seen:
        choose(seen.page, served, LIVE)
        command(seen.page)
        seen.page.get_by_role("button", name="Permit").dblclick()
        seen.page.wait_for_timeout(500)
    assert {message["ask"] for message in live.heard} == {1}


def test_u8_without_the_command_only_stop_is_there(seen: Seen, served: Served, live: LiveRun) -> None:
    served.take("Bob")
    choose(seen.page, served, LIVE)
    seen.page.get_by_text("Bob commands").wait_for(timeout=20_000)
    for name in ("Pause", "Continue", "Single steps", "Cancel", "Permit", "Refuse"):
        assert seen.page.get_by_role("button", name=name).is_disabled()
    seen.page.get_by_role("button", name="STOP").click()
    seen.page.wait_for_timeout(500)
    assert (live.stops, live.heard) == (1, [])


def test_a_break_point_is_pressed_with_the_keyboard(seen: Seen, served: Served, live: LiveRun) -> None:
    page = seen.page
    choose(page, served, LIVE)
    command(page)
    spot = page.get_by_role("button", name="Break point at between")
    spot.focus()
    page.keyboard.press("Enter")
    page.wait_for_timeout(1000)
    assert [(message["do"], message["at"], message["on"]) for message in live.heard] == [
        ("break", "between", True)
    ]
    assert spot.get_attribute("aria-pressed") == "true"
    page.keyboard.press(" ")
    page.wait_for_timeout(1000)
    assert live.heard[-1]["on"] is False


def test_all_can_be_reached_with_the_keyboard(seen: Seen, served: Served, live: LiveRun) -> None:
    page = seen.page
    choose(page, served, LIVE)
    command(page)
    reached = set()
    for _ in range(40):
        page.keyboard.press("Tab")
        reached.add(page.evaluate("document.activeElement.textContent || document.activeElement.id"))
    assert {"STOP", "Pause", "Continue", "Single steps", "Cancel", "Permit", "Refuse"} <= reached


def test_the_live_view_of_a_run_that_has_one_is_led_to(served: Served, live: LiveRun) -> None:
    """The page links to no other page, whatever is in the run's folder."""
    address = live.folder / "view_address"
    with browsing(DESK) as seen:
        choose(seen.page, served, OVER)
        seen.page.get_by_text(f"handcart view {served.runs / OVER}").wait_for(timeout=20_000)
    ours = "http://127.0.0.1:8123/#token=a-_9"
    for wrong in (
        "http://evil.example",
        "javascript:alert(1)",
        ours.replace("/#", ".evil.example/#"),
        ours + "<",
    ):
        address.write_text(wrong, encoding="utf-8")
        assert served.ask("GET", f"/api/runs/{LIVE}").json["view"] is None
    address.write_text(ours, encoding="utf-8")
    assert served.ask("GET", f"/api/runs/{LIVE}").json["view"] == ours


@pytest.mark.parametrize("run", [LIVE, OVER])
def test_axe_finds_nothing(seen: Seen, served: Served, live: LiveRun, run: str) -> None:
    choose(seen.page, served, run)
    command(seen.page)
    seen.page.wait_for_timeout(1000)
    assert axe_findings(seen.page) == []


def test_a_lost_connection_is_told_and_comes_back(served: Served, live: LiveRun) -> None:
    """The server ends, and another one begins at its port: runs hear nothing of it."""
    with browsing(DESK) as seen:
        choose(seen.page, served, LIVE)
        seen.page.get_by_text("connected", exact=True).wait_for(timeout=20_000)
        served.end()
        seen.page.get_by_text("connection lost: runs go on without this page").wait_for(timeout=20_000)
        assert seen.page.get_by_role("button", name="STOP").is_disabled()
        again: Any = Server(served.runs, None, served.server.port)
        again._guard.token = served.token
        over = threading.Event()
        thread = threading.Thread(target=again.serve, args=(over.is_set,))
        thread.start()
        try:
            seen.page.get_by_text("connected", exact=True).wait_for(timeout=20_000)
        finally:
            over.set()
            thread.join()
    assert (live.heard, live.stops) == ([], 0)


def test_u10_what_a_run_is_called_is_never_run(served: Served, live: LiveRun) -> None:
    """Names of tasks, situations, actions and operators, and reasons are only shown."""
    asks = live.status["asks"]
    with browsing(DESK) as seen:
        page = seen.page
        choose(page, served, LIVE)
        for payload in PAYLOADS:
            live.status["situation"] = payload
            live.status["asks"] = {**asks, "do": payload, "from": payload, "with": {payload: payload}}
            live.status["commands"] = [
                {"number": 1, "do": payload, "at": payload, "by": payload, "sim_time_s": 1.0}
            ]
            page.locator("#commands").get_by_text(payload, exact=False).first.wait_for(timeout=20_000)
            assert page.evaluate("typeof attacked") == "undefined", payload
        assert page.get_by_role("heading", name="Commands").is_visible()
        assert [request for request in seen.requests if "evil" in request] == []
        page.screenshot()


def test_u10_what_a_journal_says_is_never_run(served: Served, live: LiveRun) -> None:
    """A network whose situations have such names, drawn."""
    names = [*PAYLOADS, "z"]
    bound = Binding.of(Modify(place="x"))
    actions = [Action(a, b, bound) for a, b in pairwise(names)]
    network = ActionNetwork.build([Situation(name, {"a": name}) for name in names], actions, names[0], "z")
    svg = to_svg(draw_network(network))
    with browsing(DESK) as seen:
        choose(seen.page, served, LIVE)
        seen.page.wait_for_timeout(2000)
        seen.page.evaluate("svg => drawNetwork({svg, situations: []})", svg)
        seen.page.wait_for_timeout(500)
        assert seen.page.evaluate("typeof attacked") == "undefined"
        assert seen.page.locator("#network script, #network img, #network a, #network iframe").count() == 0
        assert seen.page.locator("#network text").count() >= 2 * len(PAYLOADS)
        assert [request for request in seen.requests if "evil" in request] == []


def test_a_real_run_is_stepped_through_and_nothing_is_left(tmp_path: Path) -> None:
    """The command with a run of another process; Ctrl-C ends it with 130, and the run continues."""
    task = walk(tmp_path)
    python = [sys.executable, "-m", "handcart"]
    console = subprocess.Popen(
        [*python, "console", str(tmp_path / "runs"), "--port", "0"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    words = ["run", str(task), "--step", "--no-report", "--runs", str(tmp_path / "runs")]
    run = subprocess.Popen(
        [*python, *words],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        assert console.stdout is not None
        url = next(word for word in console.stdout.readline().split() if word.startswith("http"))
        assert "Ctrl-C ends the page, and no run" in console.stdout.readline()
        with browsing(DESK) as seen:
            page = seen.page
            page.goto(url)
            page.locator("[data-name=walk-0] button").click(timeout=60_000)
            command(page)
            page.get_by_text("MOVE_TO from at_home to between").wait_for(timeout=60_000)
            page.get_by_role("button", name="Permit").click()
            page.get_by_text("MOVE_TO from between to at_shelf").wait_for(timeout=60_000)
            console.send_signal(signal.SIGINT)
            _, errors = console.communicate(timeout=20)
            assert (console.returncode, errors) == (130, "")
        time.sleep(0.5)
        assert run.poll() is None
    finally:
        console.kill()
        run.send_signal(signal.SIGINT)
        run.wait(30)
