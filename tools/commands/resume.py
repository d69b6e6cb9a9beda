"""`handcart resume` and `handcart ack`: resume a run that broke off."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

if TYPE_CHECKING:
    from handcart.networks.events.run_observer import RunObserver
    from handcart.tools.terminal.progress import Progress

Permit = Literal["ask", "always", "never"]
GHOST_TIMEOUT_S = 60.0
"""[s] for which a resumed run waits for the node of its killed program to leave."""
RunFolder = Annotated[Path, typer.Argument(help="the run's folder")]


def resume(
    run: Annotated[Path | None, typer.Argument(help="the run's folder (default: runs/latest)")] = None,
    confirm: Annotated[
        int | None,
        typer.Option(help="RECORD: the last one that you have seen; needed where a real robot moves"),
    ] = None,
    permit: Annotated[Permit, typer.Option(help="actions with `permit: operator`")] = "ask",
    sync: Annotated[
        bool | None,
        typer.Option(
            "--sync/--no-sync", help="whether the journal waits for the disk; a real robot's does by default"
        ),
    ] = None,
    node: Annotated[
        bool,
        typer.Option("--node", help="publish it in ROS 2 and take commands there; simulated: in real time"),
    ] = False,
    node_namespace: Annotated[str, typer.Option(help="namespace of --node's topics and services")] = "",
    as_json: Annotated[bool, typer.Option("--json", help="end with one JSON object on stdout")] = False,
) -> None:
    """Print what is known, expected and unknown of the state of an interrupted run, then resume the run."""
    from handcart.tools.terminal.first_use import first_words

    if node_namespace and not node:
        raise typer.BadParameter("--node-namespace without --node; needed: both")
    with first_words("loading the run") as progress_begins:
        import orjson

        from handcart.evaluation.trials.running import resume_task
        from handcart.files.printable import printable
        from handcart.networks.coordination.interrupts import Interrupts
        from handcart.networks.operator.permits import Permits
        from handcart.networks.run_files.run_names import latest_run
        from handcart.networks.runs.run_options import RunOptions
        from handcart.tools.terminal.next_steps import ended_words, next_steps
        from handcart.tools.terminal.progress import Progress

        run = run or latest_run(Path("runs"))
        permits = Permits(permit)
        with Interrupts() as interrupts, Progress(progress_begins) as progress, ExitStack() as stack:
            shown = [stack.enter_context(_node(run, node_namespace, progress))] if node else []
            permits.asking, permits.typed = progress.ask, progress.typed
            summary, status = resume_task(
                run,
                confirm,
                RunOptions(
                    sync=sync,
                    draw=True,
                    report=True,
                    playback=True,
                    permits=permits,
                    interrupts=interrupts,
                    observers=(progress, *shown),
                ),
            )
            progress.end()
            if as_json:
                print(orjson.dumps(summary).decode(), flush=True)
            else:
                print(printable(ended_words({**summary, "run_dir": run})), flush=True)
                progress.offer(next_steps(summary))
    sys.exit(status)


@contextmanager
def _node(run: Path, namespace: str, progress: Progress) -> Iterator[RunObserver]:
    """Yield the node of a resumed run, which waits until that of its killed program has left."""
    from handcart.networks.runs.resuming import task_of
    from handcart.tools.node.open_node import opened_node

    task_of(run)  # what cannot be resumed needs no node
    with opened_node(namespace, progress.say, GHOST_TIMEOUT_S) as opened:
        yield opened


def ack(
    run: RunFolder,
    record: Annotated[int, typer.Argument(help="the record that waits, as `run` or `resume` shows it")],
) -> None:
    """Acknowledge that, after a GiveUp or an interruption, everything is again in the state before the
    action.

    The run can then be resumed.
    """
    from handcart.files.printable import printable
    from handcart.networks.operator.acknowledging import acknowledge

    reason = acknowledge(run, record)
    print(printable(f"acknowledged: {reason}; handcart resume {run} continues it"))
