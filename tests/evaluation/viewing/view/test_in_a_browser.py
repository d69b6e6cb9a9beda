"""The page in a real browser, and the command that serves it."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

pytest.importorskip("viser", reason="the extra view isn't installed")

from tests.browser import DESK, PHONE, Seen, axe_findings, browsing, needs_browser

COMMAND = [sys.executable, "-m", "handcart", "view"]


@contextmanager
def viewing(folder: Path) -> Iterator[tuple[subprocess.Popen[str], str]]:
    command = [*COMMAND, str(folder), "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            said = process.stdout.readline()
            found = re.search(r"http://127\.0\.0\.1:\d+/#token=\S+", said)
            assert found, said
            yield process, found.group()
        finally:
            process.kill()


def drawn(seen: Seen) -> np.ndarray[tuple[int, ...], np.dtype[np.int16]]:
    return np.asarray(Image.open(BytesIO(seen.page.screenshot())).convert("RGB"), dtype=np.int16)


@pytest.mark.slow
def test_ctrl_c_ends_it_at_once(toured: Path) -> None:
    with viewing(toured) as (process, url):
        with urllib.request.urlopen(url, timeout=20) as page:
            assert page.status == 200
        process.send_signal(signal.SIGINT)
        began = time.monotonic()
        out, errors = process.communicate(timeout=20)
    assert process.returncode == 130
    assert (out, errors) == ("", "")
    assert time.monotonic() - began < 10.0


@needs_browser
@pytest.mark.slow
@pytest.mark.parametrize("size", [PHONE, DESK])
def test_it_opens_draws_and_goes_to_another_time(toured: Path, size: tuple[int, int]) -> None:
    with viewing(toured) as (_, url), browsing(size) as seen:
        seen.page.goto(url)
        seen.page.get_by_text("MOVE_TO").first.wait_for(timeout=60_000)
        seen.page.wait_for_timeout(4000)
        before = drawn(seen)
        seen.page.locator("input[type=text]").first.fill("6")
        seen.page.keyboard.press("Enter")
        seen.page.get_by_text("6.0 s").first.wait_for(timeout=20_000)
        seen.page.wait_for_timeout(3000)
        after = drawn(seen)
    world = np.s_[: size[1] // 3, : size[0] // 2]
    assert before[world].std() > 5.0, "nothing is drawn"
    assert (np.abs(after - before).max(axis=2) > 40).sum() > 200, "nothing has moved"
    assert seen.errors == []
    own = url.partition("#")[0]
    leaving = [request for request in seen.requests if not request.startswith((own, f"blob:{own}", "data:"))]
    assert leaving == []
    assert "token" not in "".join(seen.requests)


@needs_browser
@pytest.mark.slow
@pytest.mark.parametrize("size", [PHONE, DESK])
def test_axe_finds_nothing(toured: Path, size: tuple[int, int]) -> None:
    """Controls that viser leaves unnamed are named, and all are reached with the keyboard."""
    with viewing(toured) as (_, url), browsing(size) as seen:
        seen.page.goto(url)
        seen.page.get_by_text("MOVE_TO").first.wait_for(timeout=60_000)
        folder = seen.page.get_by_role("button", name="Show")
        folder.focus()
        seen.page.keyboard.press("Enter")
        seen.page.get_by_role("checkbox", name="driven path").wait_for(timeout=20_000)
        assert folder.get_attribute("aria-expanded") == "true"
        assert axe_findings(seen.page) == []
        assert seen.page.get_by_role("slider", name="time [s]").count() == 1


@needs_browser
@pytest.mark.slow
def test_without_the_token_the_page_says_so(toured: Path) -> None:
    with viewing(toured) as (_, url), browsing(DESK) as seen:
        seen.page.goto(url.partition("#")[0])
        seen.page.get_by_text("The token is missing").wait_for(timeout=20_000)
        assert seen.page.get_by_text("MOVE_TO").count() == 0, "it shows the run all the same"
