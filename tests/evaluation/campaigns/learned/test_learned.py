"""Outcome probabilities learned from trials: dependence on an action's own past is found, other is
rejected.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.campaigns.walk import walk
from handcart.evaluation.campaigns.data.campaign_folder import CampaignFolder, NoCampaign
from handcart.evaluation.campaigns.data.trial import ActionEnd, Trial
from handcart.evaluation.campaigns.data.walked_trials import WalkedTrials
from handcart.evaluation.campaigns.learned.held_out import hold_out
from handcart.evaluation.campaigns.learned.learned import Learned, NothingLearned
from handcart.evaluation.campaigns.learned.learned_odds import LearnedOdds, best_pooling
from handcart.evaluation.campaigns.learned.prediction import predict
from handcart.evaluation.campaigns.learned.seen_actions import SeenActions
from handcart.evaluation.campaigns.walks.odds import EndCode
from handcart.networks.task.task_file import Task, load_task
from handcart.robotics.numerics.arrays import FloatArray, Int8Array, Int32Array

TRIALS = 600
STACK_BLOCKS = Path(__file__).parents[4] / "tasks" / "stack_blocks" / "task.yaml"


class SecondTimeWorse:
    """A first attempt ends well in 7 of 10, another one in 2 of 10; after a Fail all takes twice as long."""

    rest_s = 3.0

    def ends(self, action: Int32Array, context: Int32Array, drawn: FloatArray) -> Int8Array:
        good = np.where(context < 2, 0.7, 0.2)
        return np.where(
            drawn < good, EndCode.SUCCESS, np.where(drawn > 0.97, EndCode.GIVE_UP, EndCode.FAIL)
        ).astype(np.int8)

    def seconds(
        self, action: Int32Array, context: Int32Array, ends: Int8Array, drawn: FloatArray
    ) -> FloatArray:
        return (10.0 + action + drawn) * np.where(context % 2, 2.0, 1.0)


@pytest.fixture
def task(tmp_path: Path) -> Task:
    return load_task(walk(tmp_path))


@pytest.fixture
def recorded(task: Task) -> Callable[[int], Iterator[Trial]]:
    """So many trials as if they had been run."""
    trials = WalkedTrials(task, SecondTimeWorse())
    return lambda count: (trials.trial(seed) for seed in range(count))


def true_figures(task: Task) -> tuple[float, float]:
    trials = WalkedTrials(task, SecondTimeWorse())
    blocks = [trials.together(number) for number in range(20, 30)]
    times = np.concatenate([trials.times(block) for block in blocks])
    return float(np.concatenate([block.success for block in blocks]).mean()), float(times.mean())


@pytest.mark.slow
def test_what_depends_on_earlier_fails_is_predicted(
    task: Task, recorded: Callable[[int], Iterator[Trial]]
) -> None:
    """Without the context it would be far off."""
    seen = SeenActions.of(task, recorded(TRIALS))
    found, (success, time_s) = predict(task, seen), true_figures(task)
    assert abs(found.success - success) < 3.0 * found.sigma[0] < 0.1
    assert abs(found.time_s - time_s) < 3.0 * found.sigma[1] < 5.0
    low, high = found.success_95
    assert low < found.success < high
    short, long = found.time_95_s
    assert short < found.time_s < long
    blind = WalkedTrials(task, LearnedOdds(task, seen, 1e9)).together(0)
    assert abs(blind.success.mean() - success) > 0.08


def test_what_was_seldom_seen_leans_on_all_contexts(
    task: Task, recorded: Callable[[int], Iterator[Trial]]
) -> None:
    """After many trials what depends on the context is believed; of one attempt after a Fail hardly."""
    many = SeenActions.of(task, recorded(TRIALS))
    assert best_pooling(task, many) <= 30.0
    first = many.context == 0
    rest = many._replace(
        **{
            name: np.concatenate([getattr(many, name)[first], getattr(many, name)[~first][:1]])
            for name in ("trial", "entry", "context", "end", "seconds")
        }
    )
    seldom = LearnedOdds(task, rest, 30.0)
    drawn = np.linspace(0.0, 1.0, 1001)
    action, context = np.zeros(1001, dtype=np.int32), np.full(1001, 3, dtype=np.int32)
    share = (seldom.ends(action, context, drawn) == EndCode.SUCCESS).mean()
    assert share == pytest.approx(0.7, abs=0.06)


@pytest.mark.slow
def test_each_half_predicts_the_other(task: Task, recorded: Callable[[int], Iterator[Trial]]) -> None:
    trust = hold_out(task, SeenActions.of(task, recorded(TRIALS)))
    assert trust.wrong is None
    assert [item.name for item in trust.tried] == ["P(goal)", "mean time [s]"] * 2
    assert len({item.predicted for item in trust.tried}) == 4


class FirstBlock(SecondTimeWorse):
    """Nothing fails, but to one action of the network, of an element of a repeat, a GiveUp comes often."""

    def __init__(self, hard: int, give_up: float) -> None:
        self.hard, self.give_up = hard, give_up

    def ends(self, action: Int32Array, context: Int32Array, drawn: FloatArray) -> Int8Array:
        lost = (action == self.hard) & (drawn < self.give_up)
        return np.where(lost, EndCode.GIVE_UP, EndCode.SUCCESS).astype(np.int8)


@pytest.mark.slow
def test_what_no_action_s_own_past_tells_is_refused() -> None:
    """The first block is often dropped, others never: the elements of a repeat cannot be distinguished."""
    task = load_task(STACK_BLOCKS)
    first = next(action.index for action in task.network.actions if action.do == "PICK_UP_BLOCK")
    for give_up, refused in ((0.6, True), (0.0, False)):
        trials = WalkedTrials(task, FirstBlock(first, give_up))
        learned = Learned(task, (), SeenActions.of(task, map(trials.trial, range(TRIALS))))
        assert (learned.trust.wrong is not None) == refused
        if refused:
            with pytest.raises(NothingLearned, match="needed: trials whose actions depend on no more than"):
                learned.check()


@pytest.mark.slow
def test_what_was_never_started_ends_a_walk(task: Task, recorded: Callable[[int], Iterator[Trial]]) -> None:
    shorter = (
        replace(trial, actions=[end for end in trial.actions if "#2" not in end.action])
        for trial in recorded(200)
    )
    learned = Learned(task, (), SeenActions.of(task, shorter))
    assert learned.unknown == ["MOVE_TO (at_home to between) #2"]
    assert any("never started" in line for line in learned.words())
    trials = WalkedTrials(task, LearnedOdds(task, learned.seen))
    ended = [item for item in map(trials.trial, range(400)) if "nobody has seen" in item.summary["reason"]]
    assert ended
    assert {item.status for item in ended} == {4}
    assert {item.actions[-1].action for item in ended} == set(learned.unknown)


def test_faults_of_the_program_teach_nothing(task: Task, recorded: Callable[[int], Iterator[Trial]]) -> None:
    trials = list(recorded(40))
    broken = [replace(trial, status=5) if trial.seed % 2 else trial for trial in trials]
    seen, kept = SeenActions.of(task, broken), SeenActions.of(task, trials[::2])
    assert all((one == other).all() for one, other in zip(seen, kept, strict=True))


def test_chosen_trials_have_their_actions(task: Task, recorded: Callable[[int], Iterator[Trial]]) -> None:
    seen = SeenActions.of(task, recorded(30))
    twice = seen.chosen(np.array([4, 4, 17]))
    assert twice.time_s.tolist() == seen.time_s[[4, 4, 17]].tolist()
    for place, trial in enumerate((4, 4, 17)):
        ours, theirs = twice.trial == place, seen.trial == trial
        assert twice.seconds[ours].tolist() == seen.seconds[theirs].tolist()
        assert twice.end[ours].tolist() == seen.end[theirs].tolist()


def test_folders_that_teach_nothing_are_refused(
    task: Task, recorded: Callable[[int], Iterator[Trial]], tmp_path: Path
) -> None:
    with pytest.raises(NoCampaign):
        Learned.read(task, [tmp_path / "nothing"])
    for level, count, wrong in (
        ("network", 30, "of --level network"),
        ("run", 3, "3 trials; needed: at least 20"),
    ):
        folder = tmp_path / level
        with CampaignFolder.made(folder, {"level": level, "shard": None}).log() as log:
            log.append(list(recorded(count)))
        with pytest.raises(NothingLearned, match=wrong):
            Learned.read(task, [folder])


def test_a_for_good_fail_is_learned_as_one(task: Task, recorded: Callable[[int], Iterator[Trial]]) -> None:
    ends = [
        [end._replace(for_good=True) if end.outcome == "Fail" else end for end in trial.actions]
        for trial in recorded(50)
    ]
    trials = [replace(trial, actions=found) for trial, found in zip(recorded(50), ends, strict=True)]
    seen = SeenActions.of(task, trials)
    assert EndCode.FAIL not in seen.end.tolist()
    assert EndCode.FOR_GOOD in seen.end.tolist()


def end(action: str, outcome: str, time_s: float) -> ActionEnd:
    source, target = action.partition("(")[2].rstrip(") #2").split(" to ")
    return ActionEnd(action, source, target, outcome, time_s)


def test_a_context_is_an_action_s_own_fails_and_what_came_before(task: Task) -> None:
    first, other, last = (
        "MOVE_TO (at_home to between)",
        "MOVE_TO (at_home to between) #2",
        "MOVE_TO (between to at_shelf)",
    )
    ends = [end(first, "Fail", 5.0), end(first, "Fail", 9.0), end(other, "Fail", 10.0)]
    ends += [end(first, "Success", 18.0), end(last, "Fail", 19.0), end(last, "Success", 21.0)]
    seen = SeenActions.of(task, [Trial(0, 0, {"sim_time_s": 24.0}, ends)])
    assert seen.entry.tolist() == [0, 0, 1, 0, 2, 2]
    assert seen.context.tolist() == [0, 3, 1, 5, 0, 3]
    assert seen.seconds.tolist() == [5.0, 4.0, 1.0, 8.0, 1.0, 2.0]
    assert (seen.time_s.tolist(), seen.rest_s.tolist()) == ([24.0], [3.0])


class SlowGiveUp(SecondTimeWorse):
    """A GiveUp takes a hundred seconds."""

    def seconds(
        self, action: Int32Array, context: Int32Array, ends: Int8Array, drawn: FloatArray
    ) -> FloatArray:
        return np.where(ends == EndCode.GIVE_UP, 100.0, 10.0 + drawn)


def test_how_long_it_takes_depends_on_how_it_ends(task: Task) -> None:
    trials = WalkedTrials(task, SlowGiveUp())
    odds = LearnedOdds(task, SeenActions.of(task, map(trials.trial, range(TRIALS))))
    drawn, action = np.linspace(0.0, 0.999, 500), np.zeros(500, dtype=np.int32)
    for code, least, most in (
        (EndCode.SUCCESS, 10.0, 11.0),
        (EndCode.FAIL, 10.0, 11.0),
        (EndCode.GIVE_UP, 100.0, 100.0),
    ):
        seconds = odds.seconds(action, action, np.full(500, code, dtype=np.int8), drawn)
        assert least - 1e-6 <= seconds.min() <= seconds.max() <= most + 1e-6


def test_halves_that_differ_do_not_predict_each_other(task: Task) -> None:
    every_other = [WalkedTrials(task, item) for item in (SecondTimeWorse(), FirstBlock(0, 0.9))]
    trials = (every_other[seed % 2].trial(seed) for seed in range(200))
    assert hold_out(task, SeenActions.of(task, trials)).wrong is not None
