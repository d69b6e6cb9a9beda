"""Screenshots of a run's page for docs: `python scripts/pictures_of_report.py RUN`.

RUN is the folder of the run that scripts/pictures draws as docs/return_book.svg.
"""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).resolve().parents[1]
HIGH = {"desk": 1500, "phone": 1300}  # [px]


def main() -> None:
    """Make the page anew, and take both pictures from its top and of the first action that failed."""
    sys.path.insert(0, str(ROOT))  # for what tests have of browsers
    from handcart.evaluation.report.report import write_report
    from tests.browser import DESK, PHONE, browsing

    with TemporaryDirectory() as folder:
        page = write_report(Path(sys.argv[1]), Path(folder) / "report.html")
        for size, (width, _) in (("desk", DESK), ("phone", PHONE)):
            with browsing((width, HIGH[size])) as seen:
                seen.page.goto(page.as_uri())
                for part, where in (("", "h1"), ("_fail", "details[open]")):
                    seen.page.locator(where).first.evaluate("each => each.scrollIntoView()")
                    path = ROOT / "docs" / f"report_{size}{part}.png"
                    seen.page.screenshot(path=path, timeout=120_000)
                    print(f"written: {path}")


if __name__ == "__main__":
    main()
