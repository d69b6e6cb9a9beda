"""Screenshots of the console for docs: `python scripts/pictures_of_console.py`.

Steps through tasks/return_book up to its fifth action in a real browser, at a desk's and a phone's size.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

REPOSITORY_ROOT = Path(__file__).resolve().parents[1]
STEP_COUNT = 4


def main() -> None:
    """Run, step, take the pictures."""
    sys.path.insert(0, str(REPOSITORY_ROOT))  # for what tests have of browsers
    from tests.browser import DESK, PHONE, browsing

    with TemporaryDirectory() as name:
        runs = ["--runs", f"{name}/runs", "--no-report"]
        handcart, task = (
            [sys.executable, "-m", "handcart"],
            str(REPOSITORY_ROOT / "tasks" / "return_book" / "task.yaml"),
        )
        subprocess.run([*handcart, "run", task, "--seed", "3", *runs], check=True, stdout=subprocess.DEVNULL)
        console = subprocess.Popen([*handcart, "console", f"{name}/runs"], stdout=subprocess.PIPE, text=True)
        words = [*handcart, "run", task, "--seed", "5", "--step", *runs]
        run = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        try:
            assert console.stdout is not None
            url = next(word for word in console.stdout.readline().split() if word.startswith("http"))
            with browsing(DESK) as seen:
                page = seen.page
                page.goto(url)
                page.locator("[data-name=return_book-5] button").click(timeout=60_000)
                page.get_by_label("Your name").fill("Ada")
                page.get_by_role("button", name="Take the command").click()
                for number in range(1, STEP_COUNT + 2):
                    page.wait_for_function(
                        "n => { const run = current(); return run && run.asks && run.asks.ask === n; }",
                        arg=number,
                        timeout=120_000,
                    )
                    if number <= STEP_COUNT:
                        page.get_by_role("button", name="Permit").click()
                page.get_by_role("button", name="Break point at in_slot").click()
                page.wait_for_timeout(3000)
                for size, (width, height) in (("desk", (1280, 1180)), ("phone", PHONE)):
                    page.set_viewport_size({"width": width, "height": height})
                    top = "document.getElementById('run').scrollIntoView()"
                    page.evaluate(top if size == "phone" else "scrollTo(0, 0)")
                    page.wait_for_timeout(1000)
                    path = REPOSITORY_ROOT / "docs" / "pictures" / f"console_{size}.png"
                    page.screenshot(path=path)
                    print(f"written: {path}")
        finally:
            run.kill()
            console.terminate()


if __name__ == "__main__":
    main()
