"""PDDL and PPDDL as tasks from conditions."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
from pydantic import ConfigDict

from handcart.backends.robot.robot import Robot
from handcart.evaluation.interchange.importing import import_file
from handcart.evaluation.interchange.task_draft import yaml_text
from handcart.files.errors import FileError
from handcart.networks.analysis.figures import network_chances
from handcart.networks.coordination.script import follow
from handcart.networks.deciding.comparison import comparison
from handcart.networks.task.task_file import Task, load_task
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.world_model import ModelView

TIRES = """
(define (domain tires) (:requirements :typing :probabilistic-effects) (:types place)
  (:predicates (at ?p - place) (spare-in ?p - place) (road ?a ?b - place) (flat) (has-spare))
  (:action drive :parameters (?a ?b - place) ; half of the drives end with a flat tire
    :precondition (and (at ?a) (road ?a ?b) (not (flat)))
    :effect (and (at ?b) (not (at ?a)) (probabilistic 1/2 (flat))))
  (:action load :parameters (?p - place) :precondition (and (at ?p) (spare-in ?p))
    :effect (and (has-spare) (not (spare-in ?p))))
  (:action change :precondition (and (has-spare) (flat)) :effect (and (not (has-spare)) (not (flat)))))
(define (problem triangle) (:domain tires) (:objects a b c d e - place)
  (:init (at a) (road a b) (road b c) (road a d) (road d e) (road e c) (spare-in d) (spare-in e))
  (:goal (at c)))
"""
ROOMS = """
(define (domain rooms) (:requirements :strips :typing) (:types ball room) (:constants hall - room)
  (:predicates (at ?r - room) (in ?b - ball ?r - room) (held ?b - ball) (free))
  (:action move :parameters (?a ?b - room) :precondition (and (at ?a) (not (= ?a ?b)))
    :effect (and (not (at ?a)) (at ?b) (increase (total-cost) 7)))
  (:action pick :parameters (?b - ball ?r - room) :precondition (and (at ?r) (in ?b ?r) (free))
    :effect (and (held ?b) (not (in ?b ?r)) (not (free))))
  (:action drop :parameters (?b - ball ?r - room) :precondition (and (at ?r) (held ?b))
    :effect (and (not (held ?b)) (in ?b ?r) (free)))
  (:action wave :parameters (?r - room) :precondition (at ?r)
    :effect (when (free) (at hall))))
"""
PROBLEM = """(define (problem two) (:domain rooms) (:objects red blue - ball attic - room)
  (:init (at hall) (in red hall) (in blue hall) (free)) (:goal (and (in red attic) (in blue attic))))
"""


class Whatever(ActionPrimitive):
    """A primitive with any parameters."""

    model_config = ConfigDict(extra="allow")

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        return
        yield


def loaded(folder: Path, domain: str, problem: str | None = None) -> Task:
    (folder / "domain.pddl").write_text(domain)
    if problem is not None:
        (folder / "problem.pddl").write_text(problem)
    data = import_file(folder / "domain.pddl", folder / "problem.pddl" if problem else None).data
    data = {"robot": "librarian", **data, "actions": [{**row, "with": {}} for row in data["actions"]]}
    (folder / "lib").mkdir()
    (folder / "lib" / "task.yaml").write_text(yaml_text(data))
    return load_task(folder / "lib" / "task.yaml", None, lambda name: Whatever)


def test_plans_of_a_classical_problem_are_shortest(tmp_path: Path) -> None:
    task = loaded(tmp_path, ROOMS, PROBLEM)
    run = follow(task.network, [])
    assert (run.outcome, len(run.lines)) == ("Success", 7)
    assert run.cost_s == 3 * 7.0 + 4 * 10.0  # three moves, and two balls picked and dropped
    assert {row.cost_s for row in task.file.actions if row.do == "MOVE"} == {7.0}


def test_what_pddl_has_and_conditions_have_not_is_named(tmp_path: Path) -> None:
    (tmp_path / "d.pddl").write_text(ROOMS + PROBLEM)
    (lost,) = import_file(tmp_path / "d.pddl").lost
    assert (lost.line, lost.construct) == (11, "(when (free) (at hall))")
    assert "the action wave is dropped" in lost.meaning


def test_objects_of_many_combinations_are_grounded_in_seconds(tmp_path: Path) -> None:
    """Of 91125 combinations, 2026 can be reached."""
    move = "(and (at ?a) (bad ?c)) :effect (and (at ?b) (not (at ?a)))"
    spoil = "(bad ?a) :effect (and (bad ?a) (not (bad ?a)))"
    objects = " ".join(f"o{number}" for number in range(45))
    (tmp_path / "d.pddl").write_text(f"""(define (domain d) (:predicates (at ?x) (bad ?x))
      (:action move :parameters (?a ?b ?c) :precondition {move})
      (:action spoil :parameters (?a) :precondition {spoil}))
    (define (problem p) (:domain d) (:objects {objects}) (:init (at o0) (bad o0)) (:goal (at o1)))""")
    begun = time.process_time()
    assert len(import_file(tmp_path / "d.pddl").data["actions"]) == 2026
    assert time.process_time() - begun < 30.0


def test_best_policy_of_a_probabilistic_problem_takes_the_safe_road(tmp_path: Path) -> None:
    task = loaded(tmp_path, TIRES)
    found = comparison(task.network, network_chances(task), "goal_probability")
    assert found.best.goal == pytest.approx((1.0, 1.0), abs=1e-9)  # by d and e, where spares are
    assert found.rule.goal == pytest.approx((0.5, 0.5), abs=1e-9)  # by b, without one


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (ROOMS, "d.pddl:1:1: there is no problem; needed: (define (problem NAME) ...)"),
        ("(define (domain a)", "d.pddl:1:1: a bracket is not closed"),
        (ROOMS + ")", "a bracket closes that none opened"),
        (ROOMS + PROBLEM.replace("(in red attic)", "(in green attic)"), "its goal can never hold"),
        (ROOMS + PROBLEM.replace("(:goal", "(:aim"), "the problem has no :goal"),
        ("(" * 100 + ")" * 100, "nested too deeply"),
    ],
)
def test_wrong_planning_files_are_refused(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "d.pddl").write_text(text)
    with pytest.raises(FileError) as error:
        import_file(tmp_path / "d.pddl")
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("goal", "head", "column"),
    [
        ("(or (in red attic) (in blue attic))", "or", 64),
        ("(and (in red attic) (forall (?b - ball) (in ?b attic)))", "forall", 84),
        ("(exists (?b - ball) (in ?b attic))", "exists", 64),
        ("(imply (in red attic) (in blue attic))", "imply", 64),
    ],
)
def test_a_goal_other_than_a_conjunction_is_refused_at_its_place(
    tmp_path: Path, goal: str, head: str, column: int
) -> None:
    (tmp_path / "d.pddl").write_text(ROOMS)
    (tmp_path / "p.pddl").write_text(PROBLEM.replace("(and (in red attic) (in blue attic))", goal))
    with pytest.raises(FileError) as error:
        import_file(tmp_path / "d.pddl", tmp_path / "p.pddl")
    assert f"p.pddl:2:{column}: {head} in the goal; allowed: a conjunction of atoms" in str(error.value)
