"""Maps as ROS and MovingAI have them, and as strangers write them (rows T1, T2, T9, T11, T13)."""

import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from handcart.files.errors import FileError
from handcart.files.maps.map_file import is_map_file, load_map, read_occupancy
from handcart.robotics.navigation.maps import turned_map

MAP = """\
image: map.pgm
resolution: 0.05
origin: [-1.0, 2.0, 0.0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
"""
LEVELS = [0, 89, 90, 100, 205, 206, 255]


@pytest.fixture
def chart(tmp_path: Path) -> Path:
    """The file of a map of seven cells in a row, in a folder of a folder."""
    folder = tmp_path / "maps"
    folder.mkdir()
    Image.fromarray(np.array([LEVELS], dtype=np.uint8)).save(folder / "map.pgm")
    (folder / "map.yaml").write_text(MAP, encoding="utf-8")
    return folder / "map.yaml"


def changed(chart: Path, *changes: tuple[str, str]) -> Path:
    text = MAP
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    chart.write_text(text, encoding="utf-8")
    return chart


def error_of(chart: Path, *changes: tuple[str, str]) -> str:
    with pytest.raises(FileError) as error:
        load_map(changed(chart, *changes))
    return str(error.value)


def test_trinary_scale_and_raw_are_read_as_nav2_reads_them(chart: Path) -> None:
    """The rule is that of nav2_map_server/src/map_io.cpp: occupied above one threshold, free below the
    other.
    """
    assert read_occupancy(chart).values.tolist() == [[100, 100, -1, -1, -1, 0, 0]]
    negated = changed(chart, ("negate: 0", "negate: 1"))
    assert read_occupancy(negated).values.tolist() == [[0, -1, -1, -1, 100, 100, 100]]
    assert read_occupancy(changed(chart, ("negate: 0", "negate: true"))).values.tolist()[0][0] == 0
    scale = changed(
        chart,
        ("negate: 0", "negate: 0\nmode: scale"),
        ("0.65", "1.0"),
        ("free_thresh: 0.196", "free_thresh: 0.0"),
    )
    assert read_occupancy(scale).values.tolist() == [[100, 65, 65, 61, 20, 19, 0]]
    grid, _ = load_map(scale)
    assert grid.occupied.tolist() == [[True, *[False] * 6]]
    assert grid.blocked.tolist() == [[*[True] * 6, False]]
    raw = changed(chart, ("negate: 0", "negate: 0\nmode: raw"))
    assert read_occupancy(raw).values.tolist() == [[0, 89, 90, 100, -1, -1, -1]]


def test_where_a_picture_is_clear_nothing_is_known(chart: Path) -> None:
    pixels = np.array([[[0, 0, 0, 255], [0, 0, 0, 254], [255, 255, 255, 255]]], dtype=np.uint8)
    Image.fromarray(pixels).save(chart.parent / "map.png")
    assert read_occupancy(changed(chart, ("map.pgm", "map.png"))).values.tolist() == [[100, -1, 0]]


def test_a_picture_is_read_by_its_absolute_path(chart: Path, tmp_path: Path) -> None:
    """ROS's map_saver writes such paths."""
    elsewhere = tmp_path / "pictures"
    elsewhere.mkdir()
    (chart.parent / "map.pgm").rename(elsewhere / "map.pgm")
    grid, _ = load_map(changed(chart, ("image: map.pgm", f"image: {elsewhere}/map.pgm")))
    assert grid.occupied.shape == (1, 7)


def test_a_map_that_is_linked_is_read(chart: Path, tmp_path: Path) -> None:
    """colcon installs packages so: each file is a link."""
    installed = tmp_path / "share"
    installed.mkdir()
    for name in ("map.yaml", "map.pgm"):
        (installed / name).symlink_to(chart.parent / name)
    assert load_map(installed / "map.yaml")[0].occupied.shape == (1, 7)


@pytest.mark.parametrize(
    "image",
    ["../secret.pgm", "below/../../secret.pgm", "link.pgm", "~/secret.pgm", "..\\secret.pgm", "", "."],
)
def test_a_picture_that_leads_out_of_the_maps_folder_is_refused(chart: Path, image: str) -> None:
    """T13"""
    (chart.parent / "map.pgm").rename(chart.parent.parent / "secret.pgm")
    (chart.parent / "link.pgm").symlink_to("../secret.pgm")
    (chart.parent / "below").mkdir()
    words = error_of(chart, ("map.pgm", repr(image)))
    assert "map.yaml:1:8: " in words
    assert "allowed: a relative path inside the root" in words


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("0.05", "1e-300", "map.yaml:2:13:"),
        ("0.05", "1e300", "map.yaml:2:13:"),
        ("0.05", ".nan", "map.yaml:2:13:"),
        ("-1.0, 2.0", "-1.0, 1e308", "map.yaml:3:16:"),
        ("2.0, 0.0]", "2.0, .inf]", "is not a finite number"),
        ("free_thresh: 0.196", "free_thresh: 0.66", "map.yaml:6:14: free_thresh is 0.66; allowed: less than"),
        ("free_thresh: 0.196", "free_thresh: -1", "map.yaml:6:14:"),
        ("negate: 0", "negate: 2", "map.yaml:4:9:"),
        ("negate: 0", "mode: binary", "map.yaml:4:7:"),
        ("resolution:", "resolutoin:", "map.yaml:2:1: unknown key 'resolutoin'; did you mean 'resolution'?"),
        ("free_thresh:", "free_tresh:", "unknown key 'free_tresh'; did you mean 'free_thresh'?"),
        ("map.pgm", "mop.pgm", "map.yaml:1:8: no picture can be read from 'mop.pgm'"),
        ("map.pgm", "/dev/zero", "map.yaml:1:8: no picture can be read from '/dev/zero'"),
        ("map.pgm", "map.yaml", "map.yaml:1:1: the picture is not a picture"),
    ],
)
def test_what_is_beyond_sense_is_refused(chart: Path, old: str, new: str, words: str) -> None:
    assert words in error_of(chart, (old, new))


def test_a_picture_that_is_a_pipe_is_not_opened(chart: Path) -> None:
    """T1"""
    (chart.parent / "map.pgm").unlink()
    os.mkfifo(chart.parent / "map.pgm")
    assert "no picture can be read" in error_of(chart)


OCTILE = "type octile\nheight 3\nwidth 5\nmap\n.GS@O\nTW...\n.....\n"


def test_a_movingai_map(tmp_path: Path) -> None:
    path = tmp_path / "arena.map"
    path.write_text(OCTILE, encoding="utf-8")
    assert is_map_file(path)
    grid, warning = load_map(path)
    assert grid.occupied.astype(int).tolist() == [[0] * 5, [1, 0, 0, 0, 0], [0, 0, 0, 1, 1]]
    assert grid.unknown.astype(int).tolist() == [[0] * 5, [0, 1, 0, 0, 0], [0] * 5]
    assert (grid.resolution, grid.origin_x) == (1.0, 0.0)
    assert warning is not None
    assert "1 m is assumed" in warning


def test_a_movingai_map_in_a_maps_file_has_its_resolution(chart: Path) -> None:
    (chart.parent / "arena.map").write_text(OCTILE.replace("\n", "\r\n"), encoding="utf-8")
    grid, warning = load_map(changed(chart, ("map.pgm", "arena.map")))
    assert (grid.resolution, grid.origin_y, warning) == (0.05, 2.0, None)
    assert grid.occupied.sum() == 3


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "type octile",
            "type hex",
            "arena.map:1:1: 'type hex' is not a line of a MovingAI map; allowed: type octile",
        ),
        ("height 3", "height -3", "arena.map:2:1:"),
        ("height 3", "height 4", "3 rows; allowed: the 4 stated"),
        ("height 3", "height 2", "3 rows; allowed: the 2 stated"),
        ("height 3", "height 999999", "rows; allowed"),
        ("width 5", "width 999999", "arena.map:5:1: 5 cells; allowed: the 999999 stated"),
        ("height 3\nwidth 5", "height 99999\nwidth 99999", "arena.map:2:1: 99999 x 99999 cells; allowed"),
        ("width 5", "width 0", "0 x 3 cells"),
        ("map\n", "nap\n", "arena.map:4:1:"),
        ("TW...", "TW..", "arena.map:6:1: 4 cells; allowed: the 5 stated in line 3"),
        ("TW...", "TW.#.", "arena.map:6:4: unknown terrain '#'; allowed: . G S @ O T W"),
        ("TW...", "TW.é.", "arena.map:6:4: unknown terrain"),
    ],
)
def test_a_wrong_movingai_map_is_told_with_its_line(tmp_path: Path, old: str, new: str, words: str) -> None:
    path = tmp_path / "arena.map"
    path.write_text(OCTILE.replace(old, new), encoding="utf-8")
    with pytest.raises(FileError) as error:
        load_map(path)
    assert words in str(error.value)


def test_unknown_cells_read_as_free_are_reported_with_a_remedy(chart: Path) -> None:
    """map_saver's own default makes grey 205 free."""
    _, warning = load_map(changed(chart, ("free_thresh: 0.196", "free_thresh: 0.25")))
    assert warning is not None
    assert "map.yaml:6:14: free_thresh 0.25 turns 1 unknown cells (grey 205) into free ones" in warning
    assert load_map(changed(chart))[1] is None
    scale = changed(
        chart, ("negate: 0", "negate: 0\nmode: scale"), ("free_thresh: 0.196", "free_thresh: 0.25")
    )
    assert load_map(scale)[1] is None


def test_map_without_a_free_cell_is_reported(chart: Path) -> None:
    """A picture whose colours are all half transparent, as some programs export a layer."""
    pixels = np.array([[[0, 0, 0, 128], [254, 254, 254, 128], [255, 255, 255, 128]]], dtype=np.uint8)
    Image.fromarray(pixels).save(chart.parent / "map.png")
    _, warning = load_map(changed(chart, ("map.pgm", "map.png")))
    assert "map.yaml:1:1: no cell is free: 0 occupied, 3 unknown; check free_thresh, negate" in str(warning)


@pytest.mark.parametrize("suffix", ["tif", "tiff", "webp"])
def test_pictures_of_mapping_programs_are_read(chart: Path, suffix: str) -> None:
    Image.fromarray(np.array([LEVELS], dtype=np.uint8)).save(chart.parent / f"map.{suffix}", lossless=True)
    plain = read_occupancy(changed(chart)).values
    assert read_occupancy(changed(chart, ("map.pgm", f"map.{suffix}"))).values.tolist() == plain.tolist()


def test_map_turned_by_less_than_half_a_cell_is_level(chart: Path) -> None:
    read = read_occupancy(changed(chart, ("2.0, 0.0]", "2.0, 0.07]")))
    assert read.origin == (-1.0, 2.0)
    assert read.warning is None
    assert read.values.shape == (1, 7)


def test_turned_map_is_resampled_with_a_warning(chart: Path) -> None:
    read = read_occupancy(changed(chart, ("2.0, 0.0]", "2.0, 1.5707963267948966]")))
    assert read.values.shape == (7, 1)
    assert read.origin == pytest.approx((-1.05, 2.0))
    assert read.values[:, 0].tolist() == read_occupancy(changed(chart)).values[0].tolist()
    assert "map.yaml:3:21: the map is turned by 1.5708 rad: its cells are resampled" in str(read.warning)


def test_turned_map_that_grows_too_large_is_refused(chart: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(turned_map, "MAX_CELLS", 10)
    message = error_of(chart, ("2.0, 0.0]", "2.0, 0.7]"))
    assert "turned, the map has 7 x 6 cells; allowed: 10 in all" in message
