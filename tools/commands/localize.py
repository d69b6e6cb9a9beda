"""`handcart localize`: a recorded log, played to a robot's outdoor localization."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from handcart.evaluation.offline_localization.logs.drive_log import DriveLog
    from handcart.evaluation.offline_localization.replay import Replayed
    from handcart.robotics.navigation.outdoors.field_noise import FieldNoise

BAG_SUFFIXES = (".bag", ".db3", ".mcap")
PACKED_BAGS = tuple(f"{suffix}{packed}" for suffix in BAG_SUFFIXES for packed in (".zstd", ".zst"))
STAMP_KINDS = ("header", "receive")
RUN_LOG = "drive.csv"
TRACK_PICTURE_SUFFIXES = (".svg", ".png", ".pdf")


def localize(
    log: Annotated[
        Path,
        typer.Argument(
            help="a CSV file with a header, a run's folder, or a ROS bag; see docs/how_to/localize.md"
        ),
    ],
    nmea: Annotated[
        Path | None, typer.Option(help="a receiver's own log (NMEA 0183) with the fixes, beside the CSV file")
    ] = None,
    robot: Annotated[
        str | None,
        typer.Option(
            help="a shipped robot, or its file, with the noise of the sensors "
            "(default: the run's robot, or that of any vehicle)"
        ),
    ] = None,
    localizer: Annotated[str, typer.Option(help="gps_filter, particle or beacons")] = "gps_filter",
    reference: Annotated[
        str | None, typer.Option(help="topic of a ROS bag on which the true poses are")
    ] = None,
    stamps: Annotated[
        str, typer.Option(help="times of a ROS bag's messages: header, or receive (when they were recorded)")
    ] = "header",
    imu_axes: Annotated[
        str | None,
        typer.Option(
            help="which axes of the IMU point forward, left and up, such as z,x,y or -x,-y,z; auto: as found"
        ),
    ] = None,
    columns: Annotated[
        str | None,
        typer.Option(
            help="a CSV file without a header: QUANTITY=COLUMN[:UNIT],... such as t=stamp:ms,v=speed:km/h"
        ),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="FILE.svg, .png or .pdf: the track as a picture")
    ] = None,
    track: Annotated[Path | None, typer.Option(help="FILE.csv: poses and what is claimed of them")] = None,
    fit: Annotated[
        bool,
        typer.Option("--fit", help="propose noise for the robot's file under which the fixes are likeliest"),
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="one JSON object on stdout")] = False,
) -> None:
    """Estimate a robot's poses from a recorded log, with their uncertainty and the rejected fixes."""
    import orjson

    from handcart.evaluation.offline_localization.noise_fit import fit_noise, in_yaml
    from handcart.evaluation.offline_localization.preparation import prepare
    from handcart.evaluation.offline_localization.replay import localizer_for, replay
    from handcart.evaluation.offline_localization.replay_chart import draw_replay
    from handcart.evaluation.offline_localization.replay_words import figures, in_words
    from handcart.files.suggest import suggest
    from handcart.tools.terminal.first_use import announced
    from handcart.tools.terminal.share_shown import share_shown

    if localizer not in LOCALIZER_KINDS:
        raise typer.BadParameter(f"unknown localizer {localizer!r}{suggest(localizer, LOCALIZER_KINDS)}")
    if output is not None and output.suffix not in TRACK_PICTURE_SUFFIXES:
        raise typer.BadParameter(
            f"unknown suffix {output.suffix!r} of a picture{suggest(output.suffix, TRACK_PICTURE_SUFFIXES)}"
        )
    if stamps not in STAMP_KINDS:
        raise typer.BadParameter(f"unknown kind of stamps {stamps!r}{suggest(stamps, STAMP_KINDS)}")
    with announced(f"reading {log}"):
        played = _read(log, nmea, reference, stamps, columns)
        whose = robot or _robot_of(log)
        given = _noise(whose)
        played, noise = prepare(log, played, given, whose is not None, imu_axes)
        thinned = played.thinned(noise.gps_period)
    with announced(f"playing {log}"), share_shown("log") as passed:
        replayed = replay(
            played,
            localizer_for(thinned, noise, localizer),
            passed,
            noise.gps_period,
            noise.gps_white if localizer != "beacons" else None,
        )
    found = figures(replayed) | {"notes": list(played.notes)}
    if not as_json:
        print("\n".join([*(f"note: {note}" for note in played.notes), in_words(replayed)]))
    if output is not None:
        draw_replay(replayed, output, f"{log.name}, {localizer}")
    if track is not None:
        _write_track(track, replayed)
    if fit:
        with announced("fitting the noise"), share_shown("fit") as passed:
            fitted = fit_noise(thinned, given, passed)
        found["fit"] = {"log_likelihood": [fitted.before, fitted.after], "turned": fitted.changed}
        if not as_json:
            print(f"\nfor the robot's file (likelier by e^{fitted.after - fitted.before:.1f}):\n")
            print(in_yaml(fitted.noise))
    if as_json:
        print(orjson.dumps(found, option=orjson.OPT_INDENT_2).decode())


LOCALIZER_KINDS = ("gps_filter", "particle", "beacons")


def _robot_of(log: Path) -> str | None:
    """Return the shipped robot that drove in a run; None for other logs and robots."""
    from handcart.backends.description.robot_names import named_robots
    from handcart.networks.journal.journal_record import JournalError
    from handcart.networks.past_runs.past_run import read_run
    from handcart.networks.run_files.run_folder import NoRun

    try:
        robot = read_run(log if log.is_dir() else log.parent).header["robot"]
    except (NoRun, JournalError):
        return None
    return robot if robot in named_robots() else None


def _noise(robot: str | None) -> FieldNoise:
    """Return the noise of wheels, gyros and receiver."""
    from handcart.backends.loading.robot_loading import load_robot
    from handcart.backends.robot.localization.noise_model import field_noise
    from handcart.robotics.navigation.outdoors.field_noise import ANY_VEHICLE

    if robot is None:
        return ANY_VEHICLE
    spec = load_robot(robot)
    return field_noise(spec, spec.antenna)


def _read(log: Path, nmea: Path | None, reference: str | None, stamps: str, columns: str | None) -> DriveLog:
    """Return the log; given a run's folder, the log in it."""
    if (log / RUN_LOG).is_file():
        log = log / RUN_LOG
    if log.is_dir() or log.name.endswith((*BAG_SUFFIXES, *PACKED_BAGS)):
        from handcart.evaluation.offline_localization.bags.bag_log import read_bag_log

        if nmea is not None:
            raise typer.BadParameter("--nmea goes with a CSV file, not with a bag")
        if columns is not None:
            raise typer.BadParameter("--columns goes with a CSV file, not with a bag")
        return read_bag_log(log, reference, "receive" if stamps == "receive" else "header")
    from handcart.evaluation.offline_localization.logs.csv_log import read_csv_log

    if reference is not None:
        raise typer.BadParameter("--reference is a bag's topic; a CSV file has true_x and true_y")
    if stamps != STAMP_KINDS[0]:
        raise typer.BadParameter("--stamps goes with a bag; a CSV file has one column `time`")
    played = read_csv_log(log, columns)
    if nmea is None:
        return played
    from handcart.evaluation.offline_localization.logs.nmea_log import with_nmea

    return with_nmea(played, nmea)


def _write_track(path: Path, replayed: Replayed) -> None:
    """Write a row for each estimate, with the pose and the upper half of its covariance."""
    from handcart.tools.terminal.writing import write_text

    lines = ["time_s,x_m,y_m,heading_rad,xx_m2,xy_m2,yy_m2,xh_m,yh_m,hh_rad2,heading_known"]
    for time, pose, spread, known in zip(
        replayed.times, replayed.poses, replayed.covariances, replayed.known, strict=True
    ):
        upper = spread[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]
        cells = [f"{time:.3f}", *(f"{item:.4f}" for item in pose), *(f"{item:.6g}" for item in upper)]
        lines.append(",".join([*cells, str(int(known))]))
    write_text(path, "\n".join(lines) + "\n")
