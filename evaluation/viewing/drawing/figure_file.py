"""Atomic and reproducible saving of a matplotlib figure."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import Any

from handcart.files.whole_file import write_whole


def save_figure(figure: Any, path: Path, **options: Any) -> None:
    """Write a figure atomically, in the format of its suffix or as SVG; equal figures give equal files.

    Raises:
        OSError: the file cannot be written.
    """
    import matplotlib

    drawn, kind = BytesIO(), path.suffix.removeprefix(".") or "svg"
    metadata = {"Date": None} if kind == "svg" else {"CreationDate": None} if kind == "pdf" else None
    with matplotlib.rc_context({"svg.hashsalt": "handcart", "svg.fonttype": "none"}):
        figure.savefig(drawn, format=kind, metadata=metadata, **options)
    write_whole(path, drawn.getvalue())
