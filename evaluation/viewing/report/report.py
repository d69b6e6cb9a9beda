"""Self-contained HTML page of a run, which loads nothing from elsewhere."""

from __future__ import annotations

import base64
import math
import shlex
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import orjson

from handcart.evaluation.viewing.explanation.explanation import Explanation, explain, relying_on_the_journal
from handcart.evaluation.viewing.explanation.explanation_words import (
    aim_words,
    cause_words,
    choice_words,
    measured_words,
)
from handcart.files.shown_path import shown_path
from handcart.files.whole_file import write_whole
from handcart.networks.drawing.network_picture import draw_network
from handcart.networks.drawing.svg import to_svg
from handcart.networks.past_runs.past_run import PastRun, read_run
from handcart.networks.run_files.run_folder import read_file
from handcart.networks.run_files.run_names import OVERVIEW_FILE, REPORT_FILE

MAX_FILE_BYTES = 16 * 2**20  # of a picture or the summary
MAX_WIDTH_PX = 640  # of an action's picture
JPEG_QUALITY = 80
MAX_PICTURES = 60  # actions with a picture; further actions have none
GAUGE_LENGTH_FACTOR = 1.15  # length of a gauge, relative to the larger of value and limit


def write_report(folder: Path, path: Path | None = None) -> Path:
    """Write the report of a run as an HTML page.

    Args:
        folder: the run's folder.
        path: path of the page; None: `report.html` in the folder.

    Returns:
        The page's path.

    Raises:
        NoRun: the folder holds no run.
        JournalError: the run's journal is damaged or inconsistent.
        OSError: the page cannot be written.
    """
    run = read_run(folder)
    with relying_on_the_journal(run):
        page = _page(run)
    path = path or folder / REPORT_FILE
    write_whole(path, page)
    return path


def _page(run: PastRun) -> str:
    from jinja2 import Environment, PackageLoader

    loader = PackageLoader("handcart.evaluation.viewing.report", "")
    pages = Environment(loader=loader, autoescape=True, trim_blocks=True)
    end = run.end
    ended = [(action.index, action.outcome) for action in run.actions]
    network = to_svg(draw_network(run.network.network, ended)) if run.network else ""
    return pages.get_template("page.html").render(
        run=run,
        sentence=_sentence(run),
        ended=end["outcome"] if end else "no end",
        network=network,
        actions=list(_actions(run)),
        aims=[f"{record['t']:.1f} s: {words}" for record, words in aim_words(run)],
        task=_shown(run),
        command=_again(run),
        span=max((action.end for action in run.actions), default=0.0) or 1.0,
        pictures=list(_pictures(run.folder)),
        figures=list(_figures(run.folder)),
    )


def _sentence(run: PastRun) -> str:
    """Return one sentence with the outcome of the run and the number of its actions."""
    end, fails = run.end, sum(action.fails for action in run.actions)
    task = str(run.header["task"])
    count = f"{len(run.actions)} action{'' if len(run.actions) == 1 else 's'} ({fails or 'none'} failed)"
    if end is None:
        return f"{task}: no end is known after {count}; it was killed, or is still running."
    reason = f": {end['reason']}" if end["reason"] else ""
    when = f"after {end['t']:.1f} s and {count}"
    return f"{task}: {end['outcome']} in situation {end['situation']} {when}{reason}."


def _shown(run: PastRun) -> str:
    """Return the path of the task's file, relative to the working directory if it is inside."""
    path = Path(str(run.header["task_path"]))
    return shown_path(path)


def _again(run: PastRun) -> str:
    """Return the command that repeats the run, as far as the journal holds its options."""
    header = run.header
    words = ["handcart", "run", _shown(run)]
    if header["backend"] != "kinematic":
        words += ["--backend", str(header["backend"])]
    words += ["--bench", str(header["bench"])] if header.get("bench") else []
    words += [] if header.get("errors", True) else ["--no-errors"]
    for name, value in (header.get("settings") or {}).items():
        words += ["--set", f"{name}={value}"]
    if (start := _own_start(run)) is not None and start != header["start"]:
        words += ["--from", str(header["start"])]
    if (begins_at := _chosen_begin(run)) is not None:
        words += ["--begins-at", begins_at]
    return shlex.join([*words, "--seed", str(header["seed"])])


def _own_start(run: PastRun) -> str | None:
    """Return the situation in which the task's file begins; None if the file doesn't name it by itself."""
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError

    try:
        read = YAML(typ="safe", pure=True).load(str(run.header.get("task_text", "")))
    except YAMLError:
        return None
    start = read.get("start") if isinstance(read, dict) else None
    return start if isinstance(start, str) else None


def _chosen_begin(run: PastRun) -> str | None:
    """Return the time of day at which the run began, if it isn't the one that the task's file implies."""
    begins_at = run.header.get("begins_at")
    first = None if run.network is None else run.network.network.aims.begins_at
    return None if begins_at is None or (first and first.isoformat() == begins_at) else str(begins_at)


def _actions(run: PastRun) -> Iterator[dict[str, Any]]:
    left = MAX_PICTURES
    for action in run.actions:
        explanation = explain(run, action.number)
        picture = _small(explanation.picture) if explanation.picture and left else ""
        drawing = _drawing(explanation.drawing) if explanation.drawing and left else ""
        left -= bool(picture or drawing)
        yield {
            "it": action,
            "why": choice_words(explanation.choice) if explanation.choice else [],
            "causes": [line for cause in explanation.causes for line in cause_words(action, cause)],
            "gauges": [gauge for cause in explanation.causes if (gauge := _gauge(cause.get("measured")))],
            "noted": action.result.get("evidence", {}),
            "residuals": list(_residuals(explanation)),
            "picture": picture,
            "drawing": drawing,
            "shows": explanation.picture.stem if explanation.picture else "",
        }


def _gauge(measured: Mapping[str, Any] | None) -> dict[str, Any] | None:
    """Return the measured value and its limit as shares of a gauge's length; None if they cannot be drawn."""
    value, limit = (measured or {}).get("value"), (measured or {}).get("limit")
    if not measured or value is None or limit is None or min(value, limit) < 0.0:
        return None
    longest = GAUGE_LENGTH_FACTOR * max(value, limit)
    if not 0.0 < longest < math.inf:
        return None
    return {"words": measured_words(measured), "value": value / longest, "limit": limit / longest}


def _residuals(explanation: Explanation) -> Iterator[dict[str, Any]]:
    for item in explanation.residuals.all:
        share = item.value / item.limit if item.limit else (0.0 if item.is_within else math.inf)
        size = f"{item.value:.3f}" if math.isfinite(item.value) else "gone"
        limit = "" if item.limit is None else f"{item.limit:g}"
        yield {
            "name": item.label,
            "size": size,
            "limit": limit,
            "share": min(share, 1.0),
            "ok": item.is_within,
        }


def _small(path: Path) -> str:
    """Return a picture, reduced to its shown width, as a data URL; empty if it is damaged."""
    content = read_file(path.parent, path.name, MAX_FILE_BYTES)
    pixels = cv2.imdecode(np.frombuffer(content or b"", np.uint8), cv2.IMREAD_COLOR) if content else None
    if pixels is None:
        return ""
    scale = min(1.0, MAX_WIDTH_PX / pixels.shape[1])
    pixels = cv2.resize(pixels, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    _, jpeg = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    return _address("image/jpeg", jpeg.tobytes())


def _drawing(path: Path) -> str:
    """Return an SVG drawing as a data URL; shown as an image, it cannot run scripts or load anything."""
    return _address("image/svg+xml", read_file(path.parent, path.name, MAX_FILE_BYTES) or b"")


def _pictures(folder: Path) -> Iterator[tuple[str, str]]:
    """Yield title and data URL of the overview, then of the surveys' drawings."""
    names = sorted(path.name for path in folder.glob("*.svg") if not path.name.startswith("explained"))
    for name in sorted(names, key=lambda item: item != OVERVIEW_FILE):
        title = "Map, what was seen and time" if name == OVERVIEW_FILE else Path(name).stem.replace("_", " ")
        yield title, _drawing(folder / name)


def _address(kind: str, content: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"


def _figures(folder: Path) -> Iterator[tuple[str, str]]:
    """Yield name and value of the numbers in the run's summary, then of its metrics."""
    content = read_file(folder, "summary.json", MAX_FILE_BYTES, missing=True)
    summary = orjson.loads(content) if content else {}
    yield from _flat({key: value for key, value in summary.items() if key != "metrics"}, "")
    yield from _flat(summary.get("metrics", {}), "")


def _flat(values: Mapping[str, Any], before: str) -> Iterator[tuple[str, str]]:
    for key, value in values.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{before}{key}.")
        elif isinstance(value, float):
            yield f"{before}{key}", f"{value:.6g}"
        else:
            yield f"{before}{key}", value if isinstance(value, str) else orjson.dumps(value).decode()
