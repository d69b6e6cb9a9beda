"""Behaviour trees of the kinds that mobile robots have, and state machines of those of RoboCup robots."""

from __future__ import annotations

PLAN_NODE = '<PlanRoute goal="{goal}" route="{route}"/>'
DRIVE_NODE = '<DriveRoute route="{route}" speed="0.4"/>'
CLEAR_NODES = "\n".join(f'<ClearMap name="Clear{item}" layer="{item}"/>' for item in ("Near", "Far"))
RECOVER_SUBTREE = f"""<ReactiveFallback name="recover">
<GoalChanged/>
<RoundRobin name="one of these">
<Sequence name="clear">
{CLEAR_NODES}
</Sequence>
<Turn angle="1.57"/>
<Pause seconds="5"/>
<ReverseABit distance="0.3" speed="0.05"/>
</RoundRobin>
</ReactiveFallback>"""


def _recovering(first: str, second: str, retries: int = 6) -> str:
    return f'<RecoveryNode number_of_retries="{retries}" name="whole">\n{first}\n{second}\n</RecoveryNode>'


def _pipeline(*children: str) -> str:
    return "<PipelineSequence>\n" + "\n".join(children) + "\n</PipelineSequence>"


def _rated(child: str, hz: str = "1.0") -> str:
    return f'<RateController hz="{hz}">\n{child}\n</RateController>'


def _decorated(opening: str, *children: str) -> str:
    return "\n".join((f"<{opening}>", *children, f"</{opening.split()[0]}>"))


def _sequence(*children: str) -> str:
    return "<Sequence>\n" + "\n".join(children) + "\n</Sequence>"


CONTEXT_SUBTREE = _recovering(PLAN_NODE, _sequence("<PlannerMayHelp/>", CLEAR_NODES), 1)
FOLLOW_SUBTREE = _recovering(DRIVE_NODE, CLEAR_NODES.splitlines()[0], 1)
VALID_ROUTE_SUBTREE = f"""<Fallback>
<ReactiveSequence>
<Inverter>
<GoalChanged/>
</Inverter>
<RouteIsFree route="{{route}}"/>
</ReactiveSequence>
{PLAN_NODE}
</Fallback>"""
TREE_BODIES = {
    "drive": _sequence(PLAN_NODE, DRIVE_NODE),
    "square": _sequence(*['<Ahead distance="1.0"/>\n<Turn angle="1.57"/>'] * 4),
    "replan_rate": _pipeline(_rated(PLAN_NODE), DRIVE_NODE),
    "replan_distance": _pipeline(
        f'<DistanceController distance="1.0">\n{PLAN_NODE}\n</DistanceController>', DRIVE_NODE
    ),
    "replan_speed": _pipeline(_decorated('SpeedController min_rate="0.1"', PLAN_NODE), DRIVE_NODE),
    "replan_goal": _pipeline(_decorated('GoalUpdater input="{goal}"', PLAN_NODE), DRIVE_NODE),
    "replan_invalid": _pipeline(_rated(VALID_ROUTE_SUBTREE, "2.0"), DRIVE_NODE),
    "recover": _recovering(_pipeline(_rated(CONTEXT_SUBTREE), FOLLOW_SUBTREE), RECOVER_SUBTREE),
    "recover_helped": _recovering(
        _pipeline('<ChoosePlanner chosen="{planner}"/>', _rated(CONTEXT_SUBTREE), FOLLOW_SUBTREE),
        _sequence("<Fallback>\n<DriverMayHelp/>\n<PlannerMayHelp/>\n</Fallback>", RECOVER_SUBTREE),
    ),
    "recover_invalid": _recovering(
        _pipeline(_rated(_recovering(VALID_ROUTE_SUBTREE, CLEAR_NODES.splitlines()[1], 1)), FOLLOW_SUBTREE),
        RECOVER_SUBTREE,
    ),
    "through_poses": _recovering(
        _pipeline(_rated(_sequence('<DropPassed goals="{goals}"/>', PLAN_NODE)), FOLLOW_SUBTREE),
        RECOVER_SUBTREE,
    ),
    "patience": _recovering(
        _decorated("ReactiveSequence", _decorated('PathLongerOnApproach length="2"', PLAN_NODE), DRIVE_NODE),
        RECOVER_SUBTREE,
    ),
    "follow_point": _decorated("KeepRunningUntilFailure", _pipeline(_rated(PLAN_NODE), DRIVE_NODE)),
    "bounds": _decorated('Parallel success_count="1"', "<InBounds/>", DRIVE_NODE),
    "subtrees": _sequence('<SubTree ID="part" goal="kitchen"/>', '<SubTree ID="part" goal="hall"/>'),
    "scripted": _sequence(
        '<Script code="tries := 0"/>',
        f'<RetryUntilSuccessful num_attempts="3">\n{_sequence(PLAN_NODE, DRIVE_NODE)}\n'
        "</RetryUntilSuccessful>",
        f'<Timeout msec="20000">\n{DRIVE_NODE}\n</Timeout>',
        '<Pause seconds="1" _skipIf="tries > 2"/>',
        f'<Switch2 variable="{{mode}}" case_1="a" case_2="b">\n{PLAN_NODE}\n{DRIVE_NODE}\n'
        "<AlwaysFailure/>\n</Switch2>",
    ),
}
"""Bodies of sixteen trees."""
PART_TREE = _decorated('BehaviorTree ID="part"', _sequence('<PlanRoute goal="{goal}"/>', "<DriveRoute/>"))


def tree_files() -> dict[str, str]:
    """Return the trees as files of BehaviorTree.CPP, half of them of version 3."""
    found = {}
    for number, (name, body) in enumerate(TREE_BODIES.items()):
        version = ' BTCPP_format="4"' if number % 2 else ""
        part = PART_TREE if name == "subtrees" else ""
        found[f"{name}.xml"] = (
            f'<root{version} main_tree_to_execute="{name}">\n<!-- of the kind {name}, with {{words}} -->\n'
            f'<BehaviorTree ID="{name}">\n{body}\n</BehaviorTree>\n{part}\n</root>\n'
        )
    return found


def _state(name: str, template: str, transitions: str, more: str = "") -> str:
    return f"  - {name}:\n      template: {template}\n      transitions: {transitions}\n{more}"


LOOK_STATE = _state("LOOK", "LookAround", "{found: GRASP, not_found: failed}")
GRASP_STATE = _state("GRASP", "Grasp", "{succeeded: BRING, aborted: LOOK}", "      params: {effort: 0.3}\n")
BRING_STATE = _state("BRING", "Drive", "{succeeded: done, aborted: failed}")
MACHINE_HEADER = "name: {}\noutcomes: [done, failed]\n"
DATA_KEYS = {
    "userdata": "      userdata: {place: table}\n",
    "keys": "      input_keys: [place]\n      output_keys: [thing]\n",
    "remapping": "      remapping: {thing: cup}\n",
    "callback": "      cbs:\n        pick: [here]\n",
}
SIDE_STATES = (
    "        states:\n          - SAY:\n              template: Say\n"
    "          - WAVE:\n              template: Wave\n"
)
CONCURRENT_STATE = (
    "  - GREET:\n        template: Concurrence\n        default_outcome: failed\n"
    "        outcome_map:\n          succeeded: {SAY: succeeded, WAVE: succeeded}\n"
    f"{SIDE_STATES}        transitions: {{succeeded: LOOK, failed: failed}}\n"
)
NESTED_STATE = (
    "  - SERVE:\n        template: StateMachine\n        outcomes: [served, aborted]\n        states:\n"
    "          - POUR:\n              template: Pour\n"
    "              transitions: {succeeded: served, aborted: aborted}\n"
    "        transitions: {served: done, aborted: failed}\n"
)
PLAIN_STATES = "states:\n" + LOOK_STATE + GRASP_STATE + BRING_STATE
STATE_MACHINES = {
    "plain": MACHINE_HEADER + PLAIN_STATES,
    **{f"with_{name}": MACHINE_HEADER + PLAIN_STATES + text for name, text in DATA_KEYS.items()},
    "initial": MACHINE_HEADER + "initial_state: GRASP\n" + PLAIN_STATES,
    "unknown_initial": MACHINE_HEADER + "initial_state: NOWHERE\n" + PLAIN_STATES,
    "top_userdata": MACHINE_HEADER + "userdata: {person: anna}\n" + PLAIN_STATES,
    "concurrence": MACHINE_HEADER + "states:\n" + CONCURRENT_STATE + LOOK_STATE + GRASP_STATE + BRING_STATE,
    "nested": MACHINE_HEADER + "states:\n" + NESTED_STATE,
    "both": MACHINE_HEADER
    + "states:\n"
    + CONCURRENT_STATE
    + LOOK_STATE
    + GRASP_STATE
    + BRING_STATE
    + NESTED_STATE,
    "mapping": MACHINE_HEADER
    + "states:\n  A:\n    type: Say\n    transitions: {done: B}\n  B:\n    type: Wave\n",
    "short": "name: {}\nstates:\n"
    "  A:\n    procedure: Dive\n    error: C\n    next: B\n"
    "  B:\n    procedure: Buoy\n    error: A\n    next: C\n"
    "  C:\n    procedure: Rise\n    next: done\n",
    "sequence": MACHINE_HEADER + "states:\n  - A:\n      template: Say\n  - B:\n      template: Wave\n",
    "named": MACHINE_HEADER
    + "states:\n  - name: A\n    state: Ask\n    transitions:\n      - [yes_said, B]\n      - [no, failed]\n"
    "  - name: B\n    state: Wave\n    transitions:\n      - {outcome: succeeded, to: done}\n",
    "outcomes": MACHINE_HEADER
    + "states:\n  - ASK:\n      template: Ask\n      transitions: {tea: done, coffee: done, error: failed}\n",
    "elsewhere": MACHINE_HEADER
    + "states:\n  - ASK:\n      template: Ask\n      transitions: {succeeded: NOT_THERE, aborted: failed}\n",
    "wrapped": "machine:\n  outcomes: [done, failed]\n  states:\n"
    "    A:\n      class: Say\n      transitions: {succeeded: done}\n",
    "preempted": MACHINE_HEADER + PLAIN_STATES.replace("aborted: LOOK}", "aborted: LOOK, preempted: failed}"),
}
"""Nineteen state machines."""
LOST_KEYS = ("userdata", "input_keys", "output_keys", "remapping", "cbs", "default_outcome", "outcome_map")


def machine_files() -> dict[str, str]:
    """Return the machines as YAML files."""
    return {
        f"{name}.yaml": text.replace("name: {}", f"name: {name}") for name, text in STATE_MACHINES.items()
    }
