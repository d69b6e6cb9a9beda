"""Measure how soon a YAML bomb is refused: `python -m benchmarks.hostile.bomb`."""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

from handcart.files.errors import FileError
from handcart.files.yaml.yaml_document import read_document

BOMB_LEVELS = 9  # nine levels of nine: 387 million values


def bomb() -> bytes:
    """Return a file of 421 bytes that expands to hundreds of millions of values."""
    lines = ["a0: &a0 [" + ", ".join(["x"] * 9) + "]"]
    lines += [f"a{n}: &a{n} [" + ", ".join([f"*a{n - 1}"] * 9) + "]" for n in range(1, BOMB_LEVELS)]
    return ("\n".join(lines) + "\n").encode().ljust(421, b"#")[:421]


def main() -> None:
    """Print the time of each of 20 tries, at most."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bomb.yaml"
        path.write_bytes(bomb())
        spent = []
        for _ in range(20):
            began = time.perf_counter()
            try:
                read_document(path)
            except FileError as error:
                refusal = str(error).splitlines()[0]
            spent.append(time.perf_counter() - began)
        first, most = 1e3 * spent[0], 1e3 * max(spent[1:])
        print(f"{path.stat().st_size} bytes, refused in {first:.1f} ms, then at most {most:.1f} ms")
        print(refusal.replace(folder, ""))


if __name__ == "__main__":
    main()
