"""Export of a campaign's trials as Parquet, one row each, readable by pandas, Polars or DuckDB.

It uses arro3, which takes 33 MB installed; pyarrow takes 170 MB.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import orjson

from handcart.evaluation.campaigns.data.trial import ActionEnd, Trial
from handcart.files.whole_file import write_whole

if TYPE_CHECKING:
    from arro3.core import Array, Field, RecordBatch

BATCH_TRIALS = 5000
"""Number of trials in one batch."""
PARQUET_COMPRESSION = "zstd(3)"
SUMMARY_COLUMNS = {
    "outcome": "text",
    "situation": "text",
    "reason": "text",
    "sim_time_s": "number",
    "actions": "integer",
    "fails": "integer",
    "replans": "integer",
}
"""Columns that are taken from a trial's summary, with their types."""
METRIC_PREFIX, VARIED_PREFIX = "metrics.", "varied."
"""Prefixes of the columns of metrics and of varied parameters."""
Column = tuple[str, str, Callable[[Trial], Any]]
"""Name and type of a column, and its value in a trial; None where the trial has no value."""


def write_parquet(trials: Collection[Trial], path: Path) -> None:
    """Write trials as Parquet, one row each, in their order.

    Metrics and varied numbers are columns `metrics.NAME` and `varied.NAME`; values that are not a
    number, a text or a boolean are written as JSON. `action_ends` lists each trial's actions,
    `injected` the faults that occurred.

    Args:
        trials: the trials.
        path: path of the file.

    Raises:
        ImportError: the extra `export` is not installed.
        OSError: the file cannot be written.
    """
    from arro3.core import RecordBatchReader, Schema
    from arro3.io import write_parquet as write

    columns = _columns(trials)
    ends = dict.fromkeys(ActionEnd._fields, "text") | {"time_s": "number", "for_good": "yes or no"}
    faults = {"fault": "text", "at_s": "number", "bitten": "integer"}
    lists = {"action_ends": ends, "injected": faults}
    fields = [_field(name, _kind(kind)) for name, kind, _ in columns]
    fields += [_field(name, _list_type(inside)) for name, inside in lists.items()]
    schema = Schema(fields)

    def batches() -> Iterator[RecordBatch]:
        from arro3.core import RecordBatch

        left = iter(trials)
        while some := list(islice(left, BATCH_TRIALS)):
            arrays = [_array(kind, [value(item) for item in some]) for _, kind, value in columns]
            arrays.append(_lists([[end._asdict() for end in item.actions] for item in some], ends))
            arrays.append(_lists([item.faults for item in some], faults))
            yield RecordBatch.from_arrays(arrays, schema=schema)

    content = io.BytesIO()
    write(RecordBatchReader.from_batches(schema, list(batches())), content, compression=PARQUET_COMPRESSION)
    write_whole(path, content.getvalue())


def _columns(trials: Iterable[Trial]) -> list[Column]:
    """Return the columns for which any trial has a value."""
    metrics: dict[str, set[str]] = {}
    varied: dict[str, None] = {}
    for trial in trials:
        for name, value in trial.summary["metrics"].items():
            if name != "untrue":
                metrics.setdefault(name, set()).add(_kind_of(value))
        varied.update(dict.fromkeys(trial.varied))
    found: list[Column] = [
        ("seed", "integer", lambda trial: trial.seed),
        ("status", "integer", lambda trial: trial.status),
        ("success", "yes or no", lambda trial: trial.success),
        ("untrue", "text", lambda trial: "; ".join(trial.untrue)),
        ("run", "text", lambda trial: trial.run_name),
    ]
    found += [(name, kind, _of_summary(name)) for name, kind in SUMMARY_COLUMNS.items()]
    for name, kinds in metrics.items():
        kind = _common(kinds)
        found.append((f"{METRIC_PREFIX}{name}", kind, _of_metrics(name, kind)))
    return found + [(f"{VARIED_PREFIX}{name}", "number", _of_varied(name)) for name in varied]


def _of_summary(name: str) -> Callable[[Trial], Any]:
    is_text = SUMMARY_COLUMNS[name] == "text"
    return lambda trial: trial.summary.get(name) if is_text or trial.measured else None


def _of_metrics(name: str, kind: str) -> Callable[[Trial], Any]:
    def value(trial: Trial) -> Any:
        found = trial.summary["metrics"].get(name)
        return orjson.dumps(found).decode() if kind == "JSON" and found is not None else found

    return value


def _of_varied(name: str) -> Callable[[Trial], Any]:
    return lambda trial: trial.varied.get(name)


def _kind_of(value: Any) -> str:
    kinds = {bool: "yes or no", int: "number", float: "number", str: "text", type(None): ""}
    return kinds.get(type(value), "JSON")


def _common(kinds: set[str]) -> str:
    """Return a type that can hold values of all these types."""
    there = kinds - {""}
    return there.pop() if len(there) == 1 else "JSON"


def _kind(kind: str) -> Any:
    from arro3.core import DataType

    kinds = {"yes or no": DataType.bool, "integer": DataType.int64, "number": DataType.float64}
    return kinds.get(kind, DataType.utf8)()


def _field(name: str, kind: Any) -> Field:
    from arro3.core import Field

    return Field(name, kind, nullable=True)


def _array(kind: str, values: Sequence[Any]) -> Array:
    from arro3.core import Array

    if kind == "number":
        values = [None if value is None else float(value) for value in values]
    return Array(values, type=_kind(kind))


def _inside(kinds: Mapping[str, str]) -> list[Field]:
    return [_field(name, _kind(kind)) for name, kind in kinds.items()]


def _list_type(kinds: Mapping[str, str]) -> Any:
    from arro3.core import DataType

    return DataType.list(_field("item", DataType.struct(_inside(kinds))))


def _lists(rows: Sequence[Sequence[Mapping[str, Any]]], kinds: Mapping[str, str]) -> Array:
    """Return an array with a list of records for each trial."""
    from arro3.core import Array, DataType, list_array, struct_array

    flat = [item for row in rows for item in row]
    arrays = [_array(kind, [item.get(name) for item in flat]) for name, kind in kinds.items()]
    ends = [0]
    for row in rows:
        ends.append(ends[-1] + len(row))
    offsets = Array(ends, type=DataType.int32())
    return list_array(offsets, struct_array(arrays, fields=_inside(kinds)), type=_list_type(kinds))
