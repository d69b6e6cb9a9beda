"""Primitives from outside, by entry point; and the README's first primitive."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.mark.parametrize("document", ["README.md", "docs/primitives.md"])
def test_a_primitive_of_another_package_runs(tmp_path: Path, document: str) -> None:
    text = (ROOT / document).read_text(encoding="utf-8")
    source = next(each for each in re.findall(r"```python\n(.*?)```", text, re.S) if "class Forward" in each)
    (tmp_path / "forward.py").write_text(source, encoding="utf-8")
    info = tmp_path / "forward-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: forward\nVersion: 1.0\n", encoding="utf-8")
    (info / "entry_points.txt").write_text(
        "[handcart.primitives]\nFORWARD = forward:Forward\n", encoding="utf-8"
    )
    said = subprocess.run(
        [sys.executable, "-m", "tools.handcart", "do", "FORWARD", "distance_m=0.3"],
        env=os.environ | {"PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}"},
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert said.returncode == 0, said.stderr
    assert said.stdout.startswith("Success")
