"""`handcart map LOG -o FOLDER`: a map from a recorded log."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

RESOLUTION_M = 0.03
SUMMARY_FILE = "summary.json"


def map_log(
    log: Annotated[
        Path,
        typer.Argument(help="a run's folder, a ROS bag, a CARMEN log or a CSV file; see docs/how_to/map.md"),
    ],
    output: Annotated[
        Path, typer.Option("-o", "--output", help="folder for map, picture, trajectory and summary")
    ],
    resolution: Annotated[
        float, typer.Option(min=0.005, max=1.0, help="side of a cell, in m")
    ] = RESOLUTION_M,
    scan_topic: Annotated[
        str | None, typer.Option(help="topic of a ROS bag (default: the one with the most scans)")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="one JSON object on stdout")] = False,
) -> None:
    """Build a map from a log of scans and odometry, with its loop closures and its uncertainty."""
    import orjson

    from handcart.evaluation.mapping.map_files import LOOPS_FILE, figures, loops_csv
    from handcart.evaluation.mapping.map_picture import draw_map
    from handcart.evaluation.mapping.map_words import in_words
    from handcart.evaluation.mapping.read_scans import read_scans
    from handcart.files.errors import FileError, Finding
    from handcart.files.maps.map_writing import MAP_FILE, TRAJECTORY_FILE, trajectory_csv, write_grid
    from handcart.robotics.navigation.mapping.map_building import build_map
    from handcart.robotics.navigation.mapping.ray_counts import MapTooLarge
    from handcart.tools.terminal.first_use import announced
    from handcart.tools.terminal.writing import NotWritable, check_folder, write_text

    from .stages import stages_shown

    check_folder(output)
    with announced(f"reading {log}"):
        scans = read_scans(log, scan_topic)
    try:
        with announced(f"mapping {log}"), stages_shown() as heard:
            built = build_map(scans, resolution, heard)
    except MapTooLarge as error:
        raise FileError(
            [Finding(str(log), 0, 0, f"the map is too large: {error}; or --resolution")]
        ) from None
    found = figures(scans, built)
    try:
        output.mkdir(parents=True, exist_ok=True)
        write_grid(output / MAP_FILE, built.counts.grid)
        draw_map(built, output / "map.svg", log.resolve().name)
    except OSError as error:
        raise NotWritable(output, error.strerror, "a folder that exists or can be made") from None
    times = scans.times[built.rows]
    write_text(output / TRAJECTORY_FILE, trajectory_csv(times, built.poses, built.covariances))
    write_text(output / LOOPS_FILE, loops_csv(scans, built))
    write_text(output / SUMMARY_FILE, orjson.dumps(found, option=orjson.OPT_INDENT_2))
    if as_json:
        print(orjson.dumps(found | {"map": str(output / MAP_FILE)}, option=orjson.OPT_INDENT_2).decode())
        return
    rows, columns = built.counts.hits.shape
    size = f"{columns * resolution:.1f} x {rows * resolution:.1f} m"
    print("\n".join([*(f"note: {note}" for note in scans.notes), in_words(scans, built)]))
    print(f"{output / MAP_FILE}: {size}, cells of {1000 * resolution:g} mm")
