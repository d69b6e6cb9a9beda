"""Maps on which robots are set down: none but shipped and generated ones unless a folder is given."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.driving.worlds.building import make_building
from benchmarks.driving.worlds.map_starts import chosen_charts, map_files, start_options
from handcart.files.maps.map_writing import write_grid
from handcart.robotics.navigation.maps.grid_map import from_boxes


def test_other_maps_are_taken_from_a_folder_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "plan").mkdir()
    walls = [(x, 2.0, 0.0, 0.1, 4.0) for x in (0.05, 5.95)] + [(3.0, y, 0.0, 6.0, 0.1) for y in (0.05, 3.95)]
    write_grid(tmp_path / "plan" / "map.yaml", from_boxes(walls, 0.05, (0.0, 0.0), (6.0, 4.0)))
    (tmp_path / "notes.yaml").write_text("format: something/1\n")
    options = start_options(None, 1)
    without = chosen_charts(tmp_path, options.parse_args([]))
    assert "skipped: no --maps FOLDER" in capsys.readouterr().out
    assert map_files(tmp_path / "plan") == [tmp_path / "plan" / "map.yaml"]
    given = chosen_charts(tmp_path, options.parse_args(["--maps", str(tmp_path / "plan")]))
    assert [chart.name for chart in given] == [*(chart.name for chart in without), "plan"]
    with pytest.raises(SystemExit, match="no map in ROS format is there"):
        (tmp_path / "empty").mkdir()
        chosen_charts(tmp_path, options.parse_args(["--maps", str(tmp_path / "empty")]))


def test_buildings_are_the_same_for_a_seed_and_have_doors() -> None:
    assert make_building(3, 2, 3) == make_building(3, 2, 3)
    assert make_building(3, 2, 3) != make_building(4, 2, 3)
    assert make_building(3, 2, 3).doors >= 5
