"""Counts over walks through a network, thousands at once."""

from __future__ import annotations

from array import array
from collections import Counter
from collections.abc import Generator

import numpy as np

from handcart.evaluation.campaigns.data.walked_trials import DRAWN, UNKNOWN, WalkedTrials
from handcart.evaluation.campaigns.walks.odds import EndCode
from handcart.evaluation.campaigns.walks.walker import NO_ACTION, Walked
from handcart.robotics.numerics.arrays import Int32Array

from .tally import WORST_TRIAL_COUNT, Blame, Tally, in_general, outcome_in_general


class WalkTally(Tally):
    """Statistics of many random walks through a network, without storing each walk as a trial."""

    def __init__(self, trials: WalkedTrials, seeds: range) -> None:
        """Prepare counts for consecutive seeds."""
        super().__init__(())
        self.trials, self._seeds = trials, seeds
        self._counts = np.zeros((len(trials.task.network.actions), len(EndCode)), dtype=np.int64)
        self._first_seen: dict[int, tuple[int, int]] = {}  # of each action: which walk, and where in it
        self._words: dict[tuple[int, ...], str] = {}
        for name in ("sim_time_s", "actions", "fails"):
            self.columns[name] = array("d")

    def count_all(self) -> Generator[int, None, None]:
        """Draw the random walks of all seeds through the network in batches; yield the size of each batch."""
        size = self.trials.side_by_side
        for number in range(self._seeds[0] // size, self._seeds[-1] // size + 1):
            first = max(self._seeds[0], number * size)
            end = min(self._seeds[-1] + 1, (number + 1) * size)
            self._add_walks(number, first - number * size, end - first)
            yield end - first
        self._name_actions()
        self.worst.sort(reverse=True)

    def _add_walks(self, number: int, begin: int, count: int) -> None:
        walked = self.trials.together(number)
        whole = slice(begin, begin + count)
        times = self.trials.times(walked)[whole]
        done, success = (walked.action != NO_ACTION)[:, whole], walked.success[whole]
        failed = done & (walked.ends[:, whole] != EndCode.SUCCESS)
        fails = failed.sum(axis=0)
        at = self.count
        self.count += count
        self.successes += int(success.sum())
        for name, values in (("sim_time_s", times), ("actions", done.sum(axis=0)), ("fails", fails)):
            self.columns[name].frombytes(values.astype(np.float64).tobytes())
        self.times.frombytes(times[success].tobytes())
        self.timed.frombytes((at + np.flatnonzero(success)).astype(np.int64).tobytes())
        self._see(walked.action[:, whole], at)
        pairs = walked.action[:, whole][done] * len(EndCode) + walked.ends[:, whole][done]
        self._counts += np.bincount(pairs, minlength=self._counts.size).reshape(self._counts.shape)
        self._add_outcomes(walked, whole)
        bad = np.flatnonzero(~success | (fails > 0))
        order = np.lexsort((bad, -fails[bad], success[bad]))[:WORST_TRIAL_COUNT]
        for column in bad[order].tolist():
            self.rank((False, not success[column], float(fails[column]), -(at + column)))

    def _add_outcomes(self, walked: Walked, whole: slice) -> None:
        """Count outcomes. Walks with equal ends have the same reason, so one trial of each is created for its
        text.
        """
        alike = np.stack([walked.last, walked.skipped, walked.where])[:, whole]
        kinds, first, times = np.unique(alike, axis=1, return_index=True, return_counts=True)
        for kind, column, count in zip(kinds.T.tolist(), first.tolist(), times.tolist(), strict=True):
            key = tuple(kind)
            if key not in self._words:
                summary = self.trials.trial_of(0, walked, whole.start + column).summary
                self._words[key] = outcome_in_general(summary)
            self.outcomes[self._words[key]] += count

    def _see(self, action: Int32Array, at: int) -> None:
        for index in set(np.unique(action).tolist()) - {NO_ACTION, *self._first_seen}:
            there = action == index
            column = int(there.any(axis=0).argmax())
            self._first_seen[index] = at + column, int(there[:, column].argmax())

    def _name_actions(self) -> None:
        for index in sorted(self._first_seen, key=lambda number: self._first_seen[number]):
            name = self.trials.names[index]
            for end, times in zip(EndCode, self._counts[index].tolist(), strict=True):
                if not times:
                    continue
                self.actions.setdefault(name, Counter())[end.outcome] += times
                if end is not EndCode.SUCCESS:
                    why = UNKNOWN if end is EndCode.UNKNOWN else DRAWN
                    blame = Blame(name.partition(" ")[0], end.outcome, "", in_general(why))
                    self.blames[blame] += times
