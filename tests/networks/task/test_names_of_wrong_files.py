"""Names that a wrong or missing file would have given are not reported as unknown."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.files.errors import FileError
from handcart.networks.task.task_file import load_task
from handcart.tasks.task_names import task_path


@pytest.mark.parametrize(
    ("key", "text", "message"),
    [
        pytest.param("objects", "detector: {}\n", "unknown key 'detector'", id="computed places"),
        pytest.param("objects", None, "missing file", id="missing objects"),
        pytest.param("places", "home: 3\n", "home is 3", id="places"),
        pytest.param("places", None, "missing file", id="missing places"),
    ],
)
def test_wrong_file_is_reported_without_its_names(
    tmp_path: Path, key: str, text: str | None, message: str
) -> None:
    task = tmp_path / "task.yaml"
    shipped = task_path(Path("fetch_and_carry"))
    for path in shipped.parent.iterdir():
        if path.is_file():
            (tmp_path / path.name).write_bytes(path.read_bytes())
    file = tmp_path / f"{key}.yaml"
    written = file.read_text() + (f"{'  ' if key == 'places' else ''}{text}")
    file.unlink()
    if text is not None:
        file.write_text(written.replace("  home: {", "  start: {"))
    with pytest.raises(FileError) as refused:
        load_task(task)
    (finding,) = refused.value.findings
    assert message in finding.message
