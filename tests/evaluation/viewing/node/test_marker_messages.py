"""Markers and other messages of a state."""

from __future__ import annotations

import math

import numpy as np

from handcart.evaluation.viewing.node.diagnostics import ERROR, OK, WARN, diagnostics_message, level_of
from handcart.evaluation.viewing.node.map_message import map_message
from handcart.evaluation.viewing.node.marker_messages import ADD, DELETE, marker_array, pose_message
from handcart.evaluation.viewing.node.seen_state import SeenState
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap

from .noted_link import NotedLink

POSE = Pose2(1.0, 2.0, math.pi / 2)


def shown(seen: SeenState, residuals: str = "") -> dict[str, object]:
    """Return the markers that are shown, by name."""
    markers = marker_array(NotedLink(), seen, "acting", residuals).markers
    assert all(marker.action in (ADD, DELETE) and marker.header.frame_id == "map" for marker in markers)
    return {marker.ns: marker for marker in markers if marker.action == ADD}


def test_markers_show_path_layers_snapshot_and_residuals() -> None:
    points = np.array([[0.0, 0.0], [1.0, 0.0], [math.nan, 1.0]])
    seen = SeenState(POSE, np.eye(3), points, points, points[:1], np.zeros((1, 7)), Pose2(0.0, 1.0, 0.0))
    found = shown(seen, "base_mm 31 (at most 25)")
    assert set(found) == {"planned", "driven", "felt", "people", "pose", "snapshot", "status", "residuals"}
    assert len(found["planned"].points) == 2  # type: ignore[attr-defined]
    assert found["residuals"].text == "base_mm 31 (at most 25)"  # type: ignore[attr-defined]
    assert found["snapshot"].pose.position.y == 1.0  # type: ignore[attr-defined]


def test_markers_without_content_are_deleted() -> None:
    nowhere = Pose2(math.nan, 0.0, 0.0)
    assert set(shown(SeenState(nowhere, np.eye(3), np.zeros((1, 2))))) == set()


def test_the_pose_has_its_covariance_in_row_order() -> None:
    covariance = np.array([[1.0, 2.0, 3.0], [2.0, 4.0, 5.0], [3.0, 5.0, 6.0]])
    full = np.reshape(pose_message(NotedLink(), POSE, covariance).pose.covariance, (6, 6))
    assert (full[0, 1], full[1, 5], full[5, 5], full[2, 2]) == (2.0, 5.0, 6.0, 0.0)


def test_a_map_begins_at_its_lowest_row() -> None:
    occupied, unknown = np.zeros((2, 3), dtype=bool), np.zeros((2, 3), dtype=bool)
    occupied[0, 1], unknown[1, 2] = True, True
    grid = GridMap(occupied, unknown, 0.05, -1.0, 2.0)
    message = map_message(NotedLink(), grid)
    assert list(message.data) == [0, 100, 0, 0, 0, -1]
    assert (message.info.width, message.info.height) == (3, 2)
    assert message.info.origin.position.x == -1.0


def test_diagnostics_name_what_needs_a_person() -> None:
    assert level_of({"state": "acting"}) == OK
    assert level_of({"state": "waiting for permission"}) == WARN
    assert level_of({"state": "ended", "outcome": "Fail"}) == WARN
    assert level_of({"state": "ended", "outcome": "GiveUp"}) == ERROR
    assert level_of({"state": "does not answer", "error": "no answer"}) == ERROR
    status = {"state": "ended", "outcome": "GiveUp", "reason": "scan: silent", "situation": "at dock"}
    (entry,) = diagnostics_message(NotedLink(), "cart", status).status
    assert (entry.hardware_id, entry.message) == ("cart", "GiveUp: scan: silent")
    assert ("situation", "at dock") in [(value.key, value.value) for value in entry.values]
