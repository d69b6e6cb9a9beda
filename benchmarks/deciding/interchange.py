"""Import trees and state machines, export the shipped tasks and read them back:
`python -m benchmarks.deciding.interchange [--trees FOLDER] [--machines FOLDER] [--hostile 300]`.

Counts tracebacks, constructs that cannot be expressed and are not named with their line, and tasks that are
not the same after the way there and back. Hostile files are damaged copies, and files that attack readers.
Status 1 if anything of it is not 0.
"""

from __future__ import annotations

import argparse
import random
import tempfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from handcart.evaluation.interchange.bt_export import parts_of_tree, tree_text
from handcart.evaluation.interchange.importing import import_file
from handcart.evaluation.interchange.jani import import_model, model_text
from handcart.evaluation.interchange.py_trees_export import parts_of_py_tree, py_tree
from handcart.evaluation.interchange.scxml import chart_text, parts_of_chart
from handcart.evaluation.interchange.task_parts import TaskParts
from handcart.evaluation.interchange.xml_tree import parse_xml_tree
from handcart.files.errors import InputError
from handcart.networks.task.task_file import load_task
from handcart.tasks.task_names import named_tasks

from .foreign_trees import machine_files, tree_files
from .lost_constructs import lost_in_machine, lost_in_tree

Scan = Callable[[str], Iterator[tuple[int, str]]]
ENTITY_BOMB_XML = (
    '<!DOCTYPE a [<!ENTITY b "bb"><!ENTITY c "&b;&b;&b;&b;&b;&b;&b;&b;"><!ENTITY d "&c;&c;&c;&c;&c;&c;">]>'
    "<root>&d;</root>"
)
EXTERNAL_ENTITY_XML = (
    '<!DOCTYPE a [<!ENTITY b SYSTEM "file:///etc/passwd">]><root><BehaviorTree>&b;</BehaviorTree></root>'
)
NO_PLACES = '{"name": "a", "locations": [], "edges": [], "initial-locations": []}'
DEEP_TREE_XML = "<root><BehaviorTree>" + "<Sequence>" * 5000 + "</Sequence>" * 5000 + "</BehaviorTree></root>"
NESTED_RETRIES_XML = '<RetryUntilSuccessful num_attempts="99">' * 8 + "<A/>" + "</RetryUntilSuccessful>" * 8
ATTACK_FILES = {
    "bomb.xml": ENTITY_BOMB_XML,
    "external.xml": EXTERNAL_ENTITY_XML,
    "deep.xml": DEEP_TREE_XML,
    "retries.xml": f'<root><BehaviorTree ID="a">{NESTED_RETRIES_XML}</BehaviorTree></root>',
    "circle.xml": '<root><BehaviorTree ID="a"><SubTree ID="a"/></BehaviorTree></root>',
    "empty.xml": '<root><BehaviorTree ID="a"/></root>',
    "anchors.yaml": "states: &a\n  - A: *a\n",
    "tagged.yaml": "states: !!python/object/apply:os.system [ls]\n",
    "deep.yaml": "states: " + "[" * 3000 + "]" * 3000 + "\n",
    "deep.jani": '{"jani-version": 1, "automata": ' + "[" * 100_000 + "]" * 100_000 + "}",
    "none.jani": f'{{"jani-version": 1, "automata": [{NO_PLACES}]}}',
}
"""Files that attack readers."""


def tried(path: Path) -> tuple[bool, set[tuple[int, str]]]:
    """Return whether a file was imported or refused in words, and the lost constructs by line."""
    try:
        return True, {(item.line, item.construct) for item in import_file(path).lost} | {
            (item.line, item.meaning) for item in import_file(path).lost
        }
    except InputError:
        return True, set()
    except Exception as error:
        print(f"{path.name}: {type(error).__name__}: {error}")
        return False, set()


def imported(kind: str, files: Mapping[Path, str], scan: Scan) -> bool:
    """Import files, and compare what is lost with what their text shows; print one line."""
    tracebacks = named = total = 0
    for path, text in files.items():
        fine, lost = tried(path)
        tracebacks += not fine
        for line, word in set(scan(text)):
            total += 1
            found = any(at == line and word.rstrip("=") in construct for at, construct in lost)
            named += found
            if not found:
                print(f"{path.name}:{line}: {word} is lost, and not named")
    print(
        f"{len(files)} {kind}: tracebacks {tracebacks}; lost constructs named {named} of {total}", flush=True
    )
    return tracebacks == 0 and named == total


def written(files: Mapping[str, str], folder: Path) -> dict[Path, str]:
    """Write files into a folder; return them by their paths."""
    folder.mkdir(exist_ok=True)
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    return {folder / name: text for name, text in files.items()}


def given(folder: Path | None, suffixes: tuple[str, ...]) -> dict[Path, str]:
    """Return the files of a folder, by their paths."""
    paths = sorted(folder.rglob("*")) if folder else []
    return {path: path.read_text(encoding="utf-8") for path in paths if path.suffix in suffixes}


def damaged(text: str, rng: random.Random) -> str:
    """Return a text with something cut out, doubled, or replaced."""
    start = rng.randrange(len(text))
    end = min(len(text), start + rng.randrange(1, 30))
    part = rng.choice(
        ["", text[start:end] * 2, "\0", "<", "&", "{", "- ", "\t", "9" * 400, '"', "é", "-1", "[]"]
    )
    return text[:start] + part + text[end:]


def hostile(count: int, seed: int, folder: Path) -> bool:
    """Import files that attack, and damaged ones; print one line."""
    rng = random.Random(seed)
    originals = {**tree_files(), **machine_files(), **_exported()}
    files = dict(ATTACK_FILES)
    while len(files) < count:
        name = rng.choice(sorted(originals))
        text = originals[name]
        for _ in range(rng.randrange(1, 4)):
            text = damaged(text, rng)
        files[f"{len(files)}_{name}"] = text
    bad = sum(not tried(path)[0] for path in written(files, folder))
    print(f"{len(files)} hostile files: tracebacks {bad}", flush=True)
    return bad == 0


def _exported() -> dict[str, str]:
    parts = TaskParts.of_task(load_task(named_tasks()["return_book"]))
    return {"own.xml": tree_text(parts), "own.scxml": chart_text(parts), "own.jani": model_text(parts)}


def there_and_back(folder: Path) -> bool:
    """Export the shipped tasks and read them back; print one line."""
    folder.mkdir(exist_ok=True)
    same = dict.fromkeys(("bt", "scxml", "jani", "py_trees"), 0)
    tasks = named_tasks()
    for path in tasks.values():
        parts = TaskParts.of_task(load_task(path))
        (folder / "task.jani").write_text(model_text(parts), encoding="utf-8")
        back = {
            "bt": parts_of_tree(parse_xml_tree(tree_text(parts).encode(), "bt")).data(),
            "scxml": parts_of_chart(parse_xml_tree(chart_text(parts).encode(), "scxml")).data(),
            "jani": import_model(folder / "task.jani").data,
            "py_trees": parts_of_py_tree(py_tree(parts, lambda _name, _given: (True, ""))).data(),
        }
        for name, data in back.items():
            same[name] += data == parts.data()
    words = ", ".join(f"{name} {count} of {len(tasks)}" for name, count in same.items())
    print(f"exported and imported, the same: {words}", flush=True)
    return set(same.values()) == {len(tasks)}


def main() -> None:
    """Print a line for each kind."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument(
        "--trees", type=Path, help="a folder with trees of BehaviorTree.CPP (default: samples)"
    )
    words.add_argument("--machines", type=Path, help="a folder with SMACH in YAML (default: samples)")
    words.add_argument("--hostile", type=int, default=300, help="number of hostile files")
    words.add_argument("--seed", type=int, default=0)
    wanted = words.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        trees = given(wanted.trees, (".xml",)) or written(tree_files(), folder / "trees")
        machines = given(wanted.machines, (".yaml", ".yml")) or written(machine_files(), folder / "machines")
        results = [
            imported("trees", trees, lost_in_tree),
            imported("state machines", machines, lost_in_machine),
            hostile(wanted.hostile, wanted.seed, folder / "hostile"),
            there_and_back(folder / "back"),
        ]
    raise SystemExit(0 if all(results) else 1)


if __name__ == "__main__":
    main()
