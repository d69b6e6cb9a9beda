"""Screenshots of pages for docs: `python scripts/pictures_of_report.py RUN [CAMPAIGN]`.

RUN is the folder of the run that docs/pictures/return_book.svg shows. CAMPAIGN is one of 40
trials of tasks/stack_blocks/task.yaml with `--faults benchmarks/campaigns/faults.yaml`.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.sync_api import Page

REPOSITORY_ROOT = Path(__file__).resolve().parents[1]
HEIGHTS_PX = {"desk": 1500, "phone": 1300}  # [px]


def main() -> None:
    """Write the pages, and take pictures at both sizes."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("run", type=Path)
    words.add_argument("campaign", type=Path, nargs="?")
    wanted = words.parse_args()
    sys.path.insert(0, str(REPOSITORY_ROOT))  # for what tests have of browsers
    with TemporaryDirectory() as folder:
        of_run(wanted.run, Path(folder) / "report.html")
        if wanted.campaign is not None:
            of_campaign(wanted.campaign, Path(folder) / "campaign.html")


def of_run(run: Path, page: Path) -> None:
    """Take pictures of a run's page: its top, and its first failed action."""
    from handcart.evaluation.viewing.report.report import write_report
    from tests.browser import DESK, PHONE, browsing

    write_report(run, page)
    for size, (width, _) in (("desk", DESK), ("phone", PHONE)):
        with browsing((width, HEIGHTS_PX[size])) as seen:
            seen.page.goto(page.as_uri())
            for part, where in (("", "h1"), ("_fail", "details[open]")):
                seen.page.locator(where).first.evaluate("each => each.scrollIntoView()")
                take(seen.page, f"report_{size}{part}")


def of_campaign(campaign: Path, page: Path) -> None:
    """Take a picture of the top of a campaign's page."""
    from handcart.evaluation.campaigns.page.campaign_page import CampaignPage
    from tests.browser import PHONE, browsing

    CampaignPage.of(campaign).write(page)
    for name, size in (("campaign_page", (1000, 2290)), ("campaign_page_phone", (PHONE[0], 1500))):
        with browsing(size) as seen:
            seen.page.goto(page.as_uri())
            take(seen.page, name)


def take(page: Page, name: str) -> None:
    """Take a picture of the present view."""
    path = REPOSITORY_ROOT / "docs" / "pictures" / f"{name}.png"
    page.screenshot(path=path, timeout=120_000)
    print(f"written: {path}")


if __name__ == "__main__":
    main()
