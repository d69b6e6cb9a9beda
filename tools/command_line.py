"""The subcommands of `handcart`: each is one function, imported when it is called."""

from __future__ import annotations

import sys
from importlib import import_module
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

OWN_COMMANDS = {
    "run": ("run_task", "run", "Run a task."),
    "do": ("commands.do_primitive", "do", "Run one primitive alone."),
    "check": ("commands.check_file", "check", "Report the faults of a file, without moving."),
    "resume": ("commands.resume", "resume", "Resume a run that broke off."),
    "ack": ("commands.resume", "ack", "Acknowledge a GiveUp."),
    "status": ("commands.operate", "status", "Report the state of a run."),
    "pause": ("commands.operate", "pause", "Hold a run where it is."),
    "continue": ("commands.operate", "go_on", "Continue after a pause."),
    "stop": ("commands.operate", "stop", "Stop a run; the robot holds."),
    "cancel": ("commands.operate", "cancel", "Restore a run's action, then end the run."),
    "restore": ("commands.operate", "restore", "Restore a run's action, and continue."),
    "permit": ("commands.operate", "permit", "Permit the action that a run asks for."),
    "refuse": ("commands.operate", "refuse", "Refuse the action that a run asks for."),
    "step": ("commands.operate", "step", "Ask for permission before every action of a run."),
    "break": ("commands.operate", "break_at", "Ask for permission before actions from a situation."),
    "draw": ("commands.draw_network", "draw", "Draw a task's action network."),
    "list": ("commands.list_names", "list_names", "List primitives, causes, backends, robots or tasks."),
    "describe": ("commands.describe", "describe", "Describe a primitive, or a backend."),
    "localize": ("commands.localize", "localize", "Estimate poses from a recorded log."),
    "explain": ("commands.explain", "explain", "Explain a run's decisions, from its folder."),
    "compare": ("past_runs.compare", "compare", "Compare two runs, action by action."),
    "replay": ("past_runs.replay", "replay", "Decide a run again with the code of today."),
    "report": ("past_runs.report", "report", "Write a run, or a campaign, as one page."),
    "export": ("past_runs.export", "export", "Write a task, a run or a campaign for other programs."),
    "import": ("commands.import_task", "import_task", "Read a behaviour tree or a state machine as a task."),
    "console": ("console.console", "console", "See all runs in the browser, and command them."),
    "node": ("node.node", "node", "Start runs from ROS 2, by services."),
    "view": ("past_runs.view", "view", "Show a run in three dimensions, in the browser."),
    "runs": ("past_runs.runs", "runs", "List the runs of a folder."),
    "schema": ("commands.schema", "schema", "Print the JSON Schema of a kind of file."),
    "robot": ("commands.draft_robot", "robot", "Draft a robot's file from what is on the air."),
    "map": ("maps.map_log", "map_log", "Build a map from a recorded log."),
    "map crop": ("maps.crop", "crop", "Cut a map to a rectangle."),
    "map turn": ("maps.turn", "turn", "Turn a map, or straighten it."),
    "map keepout": ("maps.keepout", "keepout", "Draw keep-out zones over a map."),
    "map compare": ("maps.compare", "compare", "Align two maps, and compare their walls."),
    "map walls": ("maps.walls", "walls", "Compare a map with the walls of a world."),
    "new": ("new.new", "new", "Begin a project, a primitive, a domain, a robot ..."),
    "make-map": ("commands.make_map", "make_map", "Draw the map of a world, in ROS format."),
    "teach": ("hardware.teach", "teach", "Record a posture into a robot's file."),
    "adopt": ("commands.adopt", "adopt", "Write calibration values into a robot's file."),
    "bench": (
        "hardware.bench",
        "bench",
        "Simulate a robot's CAN drives or ROS 2 topics in a process.",
    ),
    "jog": ("hardware.jog", "jog", "Move one axis of a real robot while a key is held."),
    "bringup": ("hardware.bringup", "bringup", "Bring a real robot up, step by step."),
    "campaign": ("campaigns.campaign", "campaign", "Run a task many times, with seeds, and count."),
    "campaign merge": ("campaigns.merge", "merge", "Merge the parts of a campaign."),
    "campaign compare": ("campaigns.compare", "compare", "Compare two campaigns, paired by seed."),
    "learn": ("campaigns.learn", "learn", "Write probabilities from campaigns into a task's file."),
    "conformance": ("commands.conformance", "conformance", "Test whether a backend keeps its contract."),
}
"""Module, function and short help of each command, by its name.

A name of two words precedes the command of the first word alone: a task's file of that name is `./merge`.
"""


def all_commands() -> dict[str, tuple[str, str]]:
    """Return the import path and the help of each command, by its name.

    The framework's commands come first, then those of the domains. If a domain of another package is broken,
    its error is printed, and only the framework's commands are returned.
    """
    from handcart.tasks.domain import BrokenDomain, domains

    own = {name: (f"{__package__}.{at}:{what}", words) for name, (at, what, words) in OWN_COMMANDS.items()}
    try:
        listed = [item for domain in domains() for item in domain.commands.items()]
    except BrokenDomain as broken:
        print(broken, file=sys.stderr)
        return own
    return own | {name: (item.function, item.help) for name, item in listed if name not in own}


PROGRAM_HELP = "Action primitives for mobile manipulators: run, check, draw and count tasks."


class LazyGroup(TyperGroup):
    """Group of all subcommands of `handcart`; the module of a subcommand is imported only when it is
    called.
    """

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of the framework's commands in the order of `OWN_COMMANDS`, then those of the
        domains.
        """
        return list(all_commands())

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the name of the called command, the command, and the remaining arguments.

        A name such as `campaign compare` has two words.
        """
        if (two := " ".join(args[:2])) in OWN_COMMANDS:
            return two, self.get_command(ctx, two), args[2:]
        return super().resolve_command(ctx, args)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Import the module of a command, and return the command."""
        own = OWN_COMMANDS.get(cmd_name)
        known = all_commands() if own is None else {cmd_name: (f"{__package__}.{own[0]}:{own[1]}", own[2])}
        if cmd_name not in known:
            from handcart.files.suggest import suggest

            ctx.fail(f"unknown command {cmd_name!r}{suggest(cmd_name, known)}")
        path, help_text = known[cmd_name]
        module, _, function = path.partition(":")
        app = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)
        app.command(cmd_name, help=help_text)(getattr(import_module(module), function))
        return typer.main.get_command(app)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the names and help of all commands, without importing any."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, help_text) for name, (_, help_text) in all_commands().items()])


app = typer.Typer(
    cls=LazyGroup,
    help=PROGRAM_HELP,
    no_args_is_help=True,
    add_completion=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


def _say_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version
        from platform import python_version

        print(f"handcart {version('handcart')} on Python {python_version()}")
        raise typer.Exit


@app.callback()
def about(
    version: Annotated[
        bool, typer.Option("--version", help="Print the version.", callback=_say_version, is_eager=True)
    ] = False,
) -> None:
    """Declare the option `--version` of `handcart`, which prints the version and exits; otherwise do
    nothing.
    """
