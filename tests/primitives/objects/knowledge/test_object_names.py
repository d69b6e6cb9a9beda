"""Names of objects, surfaces and spots in a task's file."""

from __future__ import annotations

import pytest

from handcart.files.errors import FileError
from handcart.networks.task.task_file import load_task
from tests.primitives.objects.fetching import TASK


def test_misspelled_spot_is_found_before_anything_runs() -> None:
    load_task(TASK / "task.yaml", {"spot": "right"})
    with pytest.raises(FileError) as wrong:
        load_task(TASK / "task.yaml", {"spot": "lefft"})
    (found,) = map(str, wrong.value.findings)
    assert found.startswith(
        "--set spot=lefft: spot: unknown spot 'lefft'; did you mean 'left'? allowed: left, right"
    )
