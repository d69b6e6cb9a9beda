"""A real browser for tests: Debian's chromium through Playwright, which fetches none itself."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser, ConsoleMessage, Page, Playwright

CHROMIUM = Path("/usr/bin/chromium")
# No GPU is asked for; a container's root may not make name spaces.
FLAGS = (
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
)
STARTS = 6  # by a driver each
PHONE, DESK = (390, 780), (1280, 800)

needs_browser = pytest.mark.skipif(
    not CHROMIUM.exists() or find_spec("playwright") is None,
    reason=f"needs {CHROMIUM} (apt-get install chromium) and the Python package playwright",
)


@dataclass
class Seen:
    """A page, and what it complained of and asked for."""

    page: Page
    errors: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)

    def heard(self, message: ConsoleMessage) -> None:
        if message.type == "error":
            self.errors.append(message.text)


def _launched() -> tuple[Playwright, Browser]:
    """A browser, and the driver that started it, which is to be stopped.

    Now and then each browser that a driver starts dies as it starts, while another driver's don't.
    """
    from playwright.sync_api import Error, sync_playwright

    for left in reversed(range(STARTS)):
        driver = sync_playwright().start()
        try:
            return driver, driver.chromium.launch(executable_path=str(CHROMIUM), args=list(FLAGS))
        except Error:
            driver.stop()
            if not left:
                raise
    raise AssertionError


def axe_findings(page: Page) -> list[str]:
    """Return the findings of axe-core on a page, of any impact: rule, impact, and the first element of
    each.
    """
    from axe_playwright_python.sync_playwright import Axe  # type: ignore[import-untyped]

    found = Axe().run(page).response["violations"]
    return [f"{item['id']} ({item['impact']}): {item['nodes'][0]['html']}" for item in found]


@contextmanager
def browsing(size: tuple[int, int]) -> Iterator[Seen]:
    """An empty page of that width and height in [px]."""
    driver, browser = _launched()
    try:
        seen = Seen(browser.new_page(viewport={"width": size[0], "height": size[1]}))
        seen.page.on("console", seen.heard)
        seen.page.on("pageerror", lambda error: seen.errors.append(str(error)))
        seen.page.on("request", lambda request: seen.requests.append(request.url))
        yield seen
    finally:
        browser.close()
        driver.stop()
