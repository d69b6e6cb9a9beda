"""What `import handcart` and `handcart --help` cost: told in milliseconds by the benchmark, held here by
what they import."""

from __future__ import annotations

import subprocess
import sys

import pytest

from benchmarks.import_times import MOST_MS, TIMED_CODE, beyond_bare_ms

IMPORTED = """
import sys
before = set(sys.modules)
try:
    {code}
except SystemExit:
    pass
print(*sorted(set(sys.modules) - before), file=sys.stderr)
"""
ALLOWED = {
    "import handcart": {"handcart"},
    "handcart --help": {"annotated_doc", "handcart", "shellingham", "typer"},
}


@pytest.mark.parametrize("name", sorted(ALLOWED))
def test_what_a_short_command_imports_is_little(name: str) -> None:
    code = IMPORTED.format(code=TIMED_CODE[name])
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    packages = {module.split(".")[0] for module in run.stderr.split()} - set(sys.stdlib_module_names)
    assert "handcart" in packages <= ALLOWED[name]


def test_the_benchmark_measures_both() -> None:
    assert beyond_bare_ms(1).keys() == MOST_MS.keys() == ALLOWED.keys()
