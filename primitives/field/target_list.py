"""Reading a list of targets: CSV or GeoJSON, in metres or by latitude and longitude."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from handcart.files.csv_table import number_in, read_csv
from handcart.files.errors import Finding
from handcart.files.findings import Findings
from handcart.files.suggest import listed
from handcart.files.yaml.yaml_document import read_document
from handcart.files.yaml.yaml_node import Node
from handcart.primitives.knowledge.place import Place
from handcart.robotics.geometry.earth_frame import EarthFrame
from handcart.robotics.geometry.pose2 import Pose2

from .field import Field
from .target import Target

METRE_COLUMNS = ("x_m", "y_m")
DEGREE_COLUMNS = ("latitude_deg", "longitude_deg")
HEADING_COLUMN = "heading_deg"
LEAST_APART = 0.3  # [m] between two targets
MAX_TARGETS = 5000  # targets
LONGEST_NAME = 60  # characters
MAX_GEOJSON_BYTES, MAX_GEOJSON_NODES = 1 << 23, 250_000
"""Limits of a file of `MAX_TARGETS` points with some further properties each."""
MAX_QUOTED_CHARACTERS = 60  # characters of what is wrong


class TargetRow(NamedTuple):
    """Row of one target in a file of targets, with its line and the text of its cells, not yet converted to
    numbers.
    """

    line: int
    columns: dict[str, int]
    words: dict[str, str]


def load_targets(path: Path, field: Field, start: Pose2) -> dict[str, Target]:
    """Return the targets by name, in the order of the file, each with the pose of the base that serves it.

    The base is to the left of the target. Its heading is along the straight line from its previous pose (for
    the first target from `start`), or the one given in the file.

    Args:
        path: CSV file with a header, name and x_m, y_m or latitude_deg, longitude_deg, optionally
            heading_deg; or GeoJSON points.
        field: field with the targets.
        start: pose of the base at the start, world_T_base.

    Raises:
        FileError: the file has faults; the error lists every faulty line.
    """
    findings = Findings()
    rows = list((_geojson if path.suffix in (".geojson", ".json") else _csv)(path, findings))
    earth = EarthFrame(field.origin.latitude_deg, field.origin.longitude_deg) if field.origin else None
    if not rows and not findings:
        findings.add(Finding(str(path), 1, 1, "no targets; allowed: at least one"))
    if len(rows) > MAX_TARGETS:
        findings.add(
            Finding(str(path), rows[MAX_TARGETS].line, 1, f"too many targets; allowed: {MAX_TARGETS}")
        )
    found: dict[str, Target] = {}
    near = _Near()
    before = start
    for row in rows[:MAX_TARGETS]:
        try:
            target = _target(row, field, earth, before, found, near)
        except _Wrong as wrong:
            findings.add(Finding(str(path), row.line, row.columns.get(wrong.key, 1), str(wrong)))
            continue
        found[target.name] = target
        before = target.stand
    findings.raise_all()
    return found


def place_of(target: Target, field: Field) -> Place:
    """Return the place of the base from which the arm lays a sensor at a target.

    The tolerances of the place are those in the field's file.
    """
    stand = target.stand
    return Place(
        x_m=stand.x,
        y_m=stand.y,
        heading_deg=math.degrees(stand.theta),
        tolerance_mm=field.stand_tolerance_mm,
        tolerance_deg=field.stand_tolerance_deg,
    )


class _Wrong(ValueError):
    def __init__(self, key: str, words: str) -> None:
        self.key = key
        super().__init__(words)


class _Near:
    """Targets grouped by squares of the ground, so that each is compared with few others."""

    def __init__(self) -> None:
        self._squares: defaultdict[tuple[int, int], list[tuple[str, float, float]]] = defaultdict(list)

    def add(self, name: str, x: float, y: float) -> None:
        self._squares[math.floor(x / LEAST_APART), math.floor(y / LEAST_APART)].append((name, x, y))

    def to(self, x: float, y: float) -> list[str]:
        """Return the names of the targets that are nearer to a point (x, y), in [m], than two targets may
        be.
        """
        column, row = math.floor(x / LEAST_APART), math.floor(y / LEAST_APART)
        squares = [(column + i, row + j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
        others = [other for square in squares for other in self._squares.get(square, ())]
        return [name for name, x_, y_ in others if math.hypot(x_ - x, y_ - y) < LEAST_APART]


def _csv(path: Path, wrong: Findings) -> Iterator[TargetRow]:
    rows = read_csv(path, MAX_TARGETS)
    first = next(rows, None)
    header = first.cells if first else ()
    wanted = [
        pair
        for pair in (METRE_COLUMNS, DEGREE_COLUMNS)
        if set(header) & {*METRE_COLUMNS, *DEGREE_COLUMNS} == set(pair)
    ]
    unknown = [
        name for name in header if name not in ("name", HEADING_COLUMN, *METRE_COLUMNS, *DEGREE_COLUMNS)
    ]
    if len(wanted) != 1 or unknown or len(set(header)) != len(header):
        allowed = "allowed: name, and x_m,y_m or latitude_deg,longitude_deg, perhaps heading_deg"
        wrong.add(
            Finding(str(path), 1, 1, f"the header is {','.join(header)[:MAX_QUOTED_CHARACTERS]!r}; {allowed}")
        )
        return
    for row in rows:
        if not row.cells:
            continue
        if len(row.cells) != len(header):
            message = f"{len(row.cells)} cells; allowed: {len(header)}, as in the header"
            wrong.add(Finding(str(path), row.line, 1, message))
            continue
        words = dict(zip(header, row.cells, strict=True))
        yield TargetRow(row.line, dict(zip(header, row.columns, strict=True)), words)


def _geojson(path: Path, wrong: Findings) -> Iterator[TargetRow]:
    document = read_document(
        path, max_bytes=MAX_GEOJSON_BYTES, max_nodes=MAX_GEOJSON_NODES, longest_line=None
    )
    features, there = document.root.deepest(("features",))
    if not there or not isinstance(features.content, list):
        allowed = "allowed: a GeoJSON FeatureCollection of points"
        wrong.add(document.finding((), f"no list of features; {allowed}"))
        return
    for number, feature in enumerate(features.content):
        place, there = feature.deepest(("geometry", "coordinates"))
        kind = feature.deepest(("geometry", "type"))[0].content
        if kind != "Point" or not there or not isinstance(place.content, list) or len(place.content) < 2:
            key = ("features", number)
            wrong.add(document.finding(key, "no point; allowed: a Point with longitude and latitude"))
            continue
        longitude, latitude = place.content[:2]
        words = {"longitude_deg": _word(longitude), "latitude_deg": _word(latitude)}
        columns = {"name": place.column, "longitude_deg": longitude.column, "latitude_deg": latitude.column}
        for column in ("name", HEADING_COLUMN):
            stated, there = feature.deepest(("properties", column))
            if there and stated.content is not None:
                words[column], columns[column] = _word(stated), stated.column
        yield TargetRow(place.line, columns, {"name": str(number + 1), **words})


def _word(node: Node) -> str:
    return str(node.content)


def _target(
    row: TargetRow,
    field: Field,
    earth: EarthFrame | None,
    before: Pose2,
    found: dict[str, Target],
    near: _Near,
) -> Target:
    name = row.words.get("name") or str(len(found) + 1)
    if len(name) > LONGEST_NAME:
        raise _Wrong("name", f"the name has {len(name)} characters; allowed: {LONGEST_NAME}")
    if name in found:
        message = (
            f"the target {name!r} is there twice, first in line {found[name].line}; allowed: each name once"
        )
        raise _Wrong("name", message)
    if METRE_COLUMNS[0] in row.words:
        key, (x, y) = METRE_COLUMNS[0], (_number(row, METRE_COLUMNS[0]), _number(row, METRE_COLUMNS[1]))
    else:
        key, (x, y) = DEGREE_COLUMNS[0], _projected(row, field, earth)
    if not field.holds(x, y):
        (west, east), (south, north) = field.x_m, field.y_m
        inside = f"allowed: the field, x {west:g} to {east:g} m, y {south:g} to {north:g} m"
        raise _Wrong(key, f"the target {name!r} at ({x:.1f}, {y:.1f}) m lies outside; {inside}")
    if there := near.to(x, y):
        message = (
            f"the target {name!r} lies where {listed(there)} does; allowed: {LEAST_APART} m apart at least"
        )
        raise _Wrong(key, message)
    heading = math.radians(_number(row, HEADING_COLUMN)) if row.words.get(HEADING_COLUMN) else None
    stand = _stand(x, y, field.aside_m, before, heading)
    near.add(name, x, y)
    return Target(name, x, y, stand, row.line, row.columns.get("name", 1))


def _number(row: TargetRow, key: str) -> float:
    value = number_in(row.words[key])
    if not math.isfinite(value):
        raise _Wrong(key, f"{key} is {row.words[key][:MAX_QUOTED_CHARACTERS]!r}; allowed: a finite number")
    return value


def _projected(row: TargetRow, field: Field, earth: EarthFrame | None) -> tuple[float, float]:
    latitude, longitude = (_number(row, key) for key in DEGREE_COLUMNS)
    for key, value, most in ((DEGREE_COLUMNS[0], latitude, 90.0), (DEGREE_COLUMNS[1], longitude, 180.0)):
        if abs(value) > most:
            raise _Wrong(key, f"{key} is {value:g}; allowed: -{most:g} to {most:g}")
    if earth is None:
        raise _Wrong(
            DEGREE_COLUMNS[0],
            "the field has no origin on the Earth; needed: its key `origin`, or x_m and y_m",
        )
    x, y = earth.to_field(latitude, longitude)
    if not field.holds(x, y):
        turned = {
            "latitude_deg has the wrong sign (hemisphere)": (-latitude, longitude),
            "longitude_deg has the wrong sign (hemisphere)": (latitude, -longitude),
            "both have the wrong sign (hemisphere)": (-latitude, -longitude),
            "latitude and longitude are exchanged": (longitude, latitude),
        }
        for words, (north, east) in turned.items():
            if abs(north) <= 90.0 and field.holds(*earth.to_field(north, east)):
                raise _Wrong(
                    DEGREE_COLUMNS[0], f"{latitude:g}, {longitude:g} lies outside the field: {words}"
                )
    return x, y


def _stand(x: float, y: float, aside: float, before: Pose2, heading: float | None) -> Pose2:
    """Return world_T_base with the target to the right, `aside` away in [m]."""
    if heading is None:
        away = math.hypot(x - before.x, y - before.y)
        straight = math.atan2(y - before.y, x - before.x)
        heading = straight + math.asin(min(1.0, aside / away)) if away > aside else before.theta
    # The right of a heading: (sin, -cos).
    return Pose2(x - aside * math.sin(heading), y + aside * math.cos(heading), heading)
