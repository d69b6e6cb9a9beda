"""Task of an activity: one thing after the other is looked for, picked, carried and placed."""

from __future__ import annotations

from handcart.files.yaml.yaml_word import yaml_word

from .definition import Definition
from .room import SIDE_TABLE, Room

HEAD = """\
# {name}, definition {instance} of BEHAVIOR-1K, as moves of single things. A thing that can't be placed is put
# back, and the robot drives home.
format: handcart-task/1
title: {title}
robot: {{parameter: robot}}
world: world.yaml
knowledge: {{map: map.yaml, places: places.yaml, objects: objects.yaml, activity: activity.yaml,
  start: home{more}}}

parameters:
  robot: {robot}

start: waiting
goal: {goal}
otherwise: home_again

situations:
  waiting: {{base: home}}
"""
SITUATIONS = """\
  at_{name}: {{base: at {source}, {name}: on {source}}}
  seen_{name}: {{base: at {source}, {name}: on {source}}}
  held_{name}: {{base: at {source}, {name}: in hand}}
  brought_{name}: {{base: at {target}, {name}: in hand}}
  placed_{name}: {{base: at {target}, {name}: on {target}}}
"""
REGRIPPING_SITUATIONS = """\
  aside_{name}: {{base: at {table}, {name}: in hand}}
  rested_{name}: {{base: at {table}, {name}: on {table}}}
  found_{name}: {{base: at {table}, {name}: on {table}}}
  regripped_{name}: {{base: at {table}, {name}: in hand}}
  again_{name}: {{base: at {target}, {name}: in hand}}
"""
ACTIONS = """\
  # {name}
  - {{do: MOVE_TO, from: {before}, to: at_{name}, cost_s: 15, with: {{place: {source}}}}}
  - {{do: LOOK_FOR, from: at_{name}, to: seen_{name}, cost_s: 6, attempts: 2, with: {{object: {name}}}}}
  - {{do: LOOK_FOR, from: at_{name}, to: seen_{name}, cost_s: 15,
     with: {{object: {name}, direction: slanted}}}}
  - {{do: PICK, from: seen_{name}, to: held_{name}, cost_s: 12, attempts: 2,
     with: {{object: {name}, to: {target}, spot: for_{name}}}}}
  - {{do: PICK, from: seen_{name}, to: held_{name}, cost_s: 20, attempts: 2,
     with: {{object: {name}, to: {target}, spot: for_{name}, grasp: next}}}}
  - {{do: MOVE_TO, from: held_{name}, to: brought_{name}, cost_s: 15, with: {{place: {target}}}}}
  - {{do: PLACE, from: brought_{name}, to: placed_{name}, cost_s: 14, attempts: 2,
     with: {{surface: {target}, spot: for_{name}}}}}
  - {{do: PLACE, from: brought_{name}, to: placed_{name}, cost_s: 40, with: {{surface: {target}}}}}
  # if no way to the goal is left
  - {{do: MOVE_TO, from: brought_{name}, to: held_{name}, cost_s: 60, with: {{place: {source}}}}}
  - {{do: PLACE, from: held_{name}, to: at_{name}, cost_s: 60, with: {{surface: {source}}}}}
  - {{do: STOW, from: seen_{name}, to: at_{name}, cost_s: 4}}
  - {{do: MOVE_TO, from: at_{name}, to: home_again, cost_s: 15, with: {{place: home}}}}
"""


REGRIPPING_ACTIONS = """\
  # if this grasp doesn't let it be placed: put down in between, and gripped from above
  - {{do: MOVE_TO, from: brought_{name}, to: aside_{name}, cost_s: 20, with: {{place: {table}}}}}
  - {{do: PLACE, from: aside_{name}, to: rested_{name}, cost_s: 14, attempts: 2, with: {{surface: {table}}}}}
  - {{do: LOOK_FOR, from: rested_{name}, to: found_{name}, cost_s: 6, attempts: 2,
     with: {{object: {name}, surface: {table}}}}}
  - {{do: PICK, from: found_{name}, to: regripped_{name}, cost_s: 12, attempts: 2,
     with: {{object: {name}, to: {target}, spot: for_{name}}}}}
  - {{do: MOVE_TO, from: regripped_{name}, to: again_{name}, cost_s: 15, with: {{place: {target}}}}}
  - {{do: PLACE, from: again_{name}, to: placed_{name}, cost_s: 14, attempts: 2,
     with: {{surface: {target}, spot: for_{name}}}}}
  - {{do: PLACE, from: again_{name}, to: placed_{name}, cost_s: 40, with: {{surface: {target}}}}}
"""


def task_text(definition: Definition, room: Room, robot: str) -> str:
    """Return the text of the file of a task in which a robot carries out an activity."""
    steps = list(_steps(room))
    goal = f"placed_{steps[-1]['name']}"
    title = definition.name.replace("_", " ").capitalize()
    has_floors = any(level.height <= 0.0 for piece in room.pieces for level in piece.levels())
    more = ", keepout: keepout.yaml" if has_floors else ""
    head = HEAD.format(
        name=definition.name,
        instance=definition.instance,
        title=yaml_word(title),
        robot=yaml_word(robot),
        goal=goal,
        more=more,
    )
    situations = "".join(SITUATIONS.format(**step) for step in steps)
    actions = "".join(ACTIONS.format(**step) for step in steps)
    regripped = {room.names[term] for term in room.at_end if room.is_regripped(term)}
    for step in (step for step in steps if step["name"] in regripped):
        situations += REGRIPPING_SITUATIONS.format(**step, table=SIDE_TABLE)
        actions += REGRIPPING_ACTIONS.format(**step, table=SIDE_TABLE)
    return f"{head}{situations}  home_again: {{base: home}}\n\nactions:\n{actions}"


def _steps(room: Room) -> list[dict[str, str]]:
    """Return name, situation before, source and target of each move, sorted by source, height and target.

    Of things from one source the taller ones are first: the arm finds no way between them to a low one.
    """
    order = sorted(
        room.at_end,
        key=lambda term: (
            room.at_first[term].level.name,
            -room.sizes[term].size_mm[2],
            room.at_end[term].level.name,
        ),
    )
    steps: list[dict[str, str]] = []
    before = "waiting"
    for term in order:
        name = room.names[term]
        source, target = room.at_first[term].level.name, room.at_end[term].level.name
        steps.append({"name": name, "before": before, "source": source, "target": target})
        before = f"placed_{name}"
    return steps
