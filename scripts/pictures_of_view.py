"""Pictures of `handcart view` for the documents: `python scripts/pictures_of_view.py RUN SECONDS`.

Writes docs/pictures/view_desk.png and docs/pictures/view_phone.png.
"""

from __future__ import annotations

import sys
import threading
from pathlib import Path

REPOSITORY_ROOT = Path(__file__).resolve().parents[1]
DRAWING_TIME_MS = 9000  # [ms] until a browser without a GPU has drawn all of it


def main() -> None:
    """Draw a run at a time, both sizes."""
    sys.path.insert(0, str(REPOSITORY_ROOT))  # for what tests have of browsers
    from handcart.evaluation.viewing.playback.playback import Playback
    from handcart.evaluation.viewing.view.replay import Replay
    from handcart.evaluation.viewing.view.serving.server import open_server
    from tests.browser import DESK, PHONE, browsing

    playback, time = Playback.read(Path(sys.argv[1])), float(sys.argv[2])
    stop = threading.Event()
    with open_server(0, "handcart view") as (server, address):
        replay = Replay(server, playback)
        replay.go_to(time)
        replay.step(0.0)
        drawing = threading.Thread(target=replay.run, args=(stop.is_set,), daemon=True)
        drawing.start()
        for name, size in (("desk", DESK), ("phone", PHONE)):
            with browsing(size) as seen:
                seen.page.goto(address)
                seen.page.wait_for_timeout(DRAWING_TIME_MS)
                notice = seen.page.get_by_text("Software WebGL rendering detected")
                if notice.count():  # where it is drawn without a GPU, the library says so
                    seen.page.locator("button.mantine-Notification-closeButton").first.click()
                    seen.page.wait_for_timeout(2000)
                path = REPOSITORY_ROOT / "docs" / "pictures" / f"view_{name}.png"
                seen.page.screenshot(path=path)
                print(f"written: {path}")
        stop.set()
        drawing.join()


if __name__ == "__main__":
    main()
