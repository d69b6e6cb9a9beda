"""Reading the places of a map."""

from __future__ import annotations

from pathlib import Path

from handcart.files.models.loading import Loaded, load_document
from handcart.files.yaml.yaml_document import read_document

from .place import Places
from .ros_goals import goals_as_places, is_goals


def load_places(path: Path) -> Loaded[Places]:
    """The places in a file of places, or of goals for nav2; raises `FileError` with every finding."""
    document = read_document(path)
    return load_document(goals_as_places(document) if is_goals(document) else document, Places)
