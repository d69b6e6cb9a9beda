"""Records of a run's journal as text messages."""

from __future__ import annotations

from collections.abc import Iterator

from handcart.networks.past_runs.past_run import PastRun, Record

from .stamped import Message, stamp

LOG_LEVELS = {"Fail": "Warning", "GiveUp": "Error"}


def event_messages(run: PastRun) -> Iterator[Message]:
    """Yield each record of a run's journal as a Foxglove log message on the topic `/events`.

    A Fail is a warning, a GiveUp an error.
    """
    from foxglove.messages import Log, LogLevel

    done = {action.number: action.do for action in run.actions}
    for record in run.records:
        time, level = float(record["t"]), LOG_LEVELS.get(str(record.get("outcome", "")), "Info")
        yield (
            time,
            "/events",
            Log(
                timestamp=stamp(time),
                level=getattr(LogLevel, level),
                message=": ".join(_words(record, done)),
                name=str(record["kind"]),
            ),
        )


def _words(record: Record, done: dict[int, str]) -> Iterator[str]:
    if record["kind"] == "RUN":
        yield str(record["task"])
    if (number := record.get("n")) is not None:
        yield f"{number}. {done.get(number, '')}"
    if "action" in record:
        yield f"from {record['action']['from']} to {record['action']['to']}"
    yield from (str(record[key]) for key in ("effect", "outcome", "situation", "reason") if record.get(key))
