"""Measure how long the analysis of networks takes: `python -m benchmarks.analysis [SIZE ...]`.

Each shape has about SIZE situations, with a probability for each action. CPU times, one process.
"""

from __future__ import annotations

import argparse
import random
import time
from collections.abc import Callable, Iterator

from handcart.networks.analysis.forecast import Forecaster
from handcart.networks.analysis.worst_cases import worst_cases
from handcart.networks.chains.chance import Chance
from handcart.networks.chains.policy import TooLarge
from handcart.networks.graph.network import Action, ActionNetwork, Binding, Situation
from handcart.primitives.driving.modify import Modify

Row = tuple[str, str, float, int, str | None]
BOUND_ACTION = Binding.of(Modify(place="x"))


def chain(size: int, rng: random.Random) -> Iterator[Row]:
    """One after the other."""
    for i in range(size - 1):
        yield f"s{i}", f"s{i + 1}", 5.0 + rng.random(), 3, None


def ladder(size: int, rng: random.Random) -> Iterator[Row]:
    """Two chains, from each of which one can change to the other."""
    half = size // 2
    for i in range(half - 1):
        for side, other in ("ab", "ba"):
            yield f"{side}{i}", f"{side}{i + 1}", 5.0 + rng.random(), 2, None
            yield f"{side}{i}", f"{other}{i}", 2.0 + rng.random(), 2, None
    yield f"b{half - 1}", f"a{half - 1}", 1.0, 2, None


def detours(size: int, rng: random.Random) -> Iterator[Row]:
    """Yield a chain each of whose steps has a detour after a Fail, as a repeat has."""
    for i in range(size // 3):
        a, b, c, z = f"s{i}", f"b{i}", f"d{i}", f"s{i + 1}"
        yield a, z, 5.0 + rng.random(), 3, b
        yield b, c, 1.0, 3, None
        yield c, z, 8.0 + rng.random(), 3, b


def grid(size: int, rng: random.Random) -> Iterator[Row]:
    """Yield a square, from corner to corner, to all four sides."""
    side = max(2, round(size**0.5))
    for x in range(side):
        for y in range(side):
            for i, j in ((x + 1, y), (x, y + 1), (x - 1, y), (x, y - 1)):
                if 0 <= i < side and 0 <= j < side:
                    yield f"g{x},{y}", f"g{i},{j}", 5.0 + rng.random(), 2, None


def tree(size: int, rng: random.Random) -> Iterator[Row]:
    """Yield each situation leads to two; every leaf leads to the goal."""
    for i in range(size - 1):
        for child in (2 * i + 1, 2 * i + 2):
            there = f"s{child}" if child < size - 1 else "z"
            yield f"s{i}", there, 5.0 + rng.random(), 2, None


def dense(size: int, rng: random.Random) -> Iterator[Row]:
    """Ten ways out of each situation, to anywhere."""
    for i in range(size):
        for _ in range(10):
            yield f"s{i}", f"s{rng.randrange(size)}", 1.0 + 20.0 * rng.random(), 2, None


def tireworld(size: int, rng: random.Random) -> Iterator[Row]:
    """Yield the rows of a tireworld: some roads cost a tyre when they fail, some places have spare tyres."""
    places = max(3, size // 4)
    for i in range(places):
        ahead, back = min(places - 1, i + rng.randint(1, 3)), max(0, i - rng.randint(1, 3))
        for j in sorted({ahead, back, rng.randrange(places)}):
            if i != j:
                yield f"at{i}", f"at{j}", 1.0 + rng.random(), 1, f"flat{i}"
        if i % 2:
            yield f"at{i}", f"spare{i}", 1.0, 1, None
            yield f"spare{i}", f"at{min(places - 1, i + 1)}", 1.0, 2, f"flat{i}"
        yield f"flat{i}", f"at{i}", 4.0 + rng.random(), 2, f"towed{i}"
        yield f"towed{i}", f"at{max(0, i - 1)}", 30.0, 1, None


NETWORK_SHAPES: dict[str, tuple[Callable[[int, random.Random], Iterator[Row]], str]] = {
    "chain": (chain, "s{last}"),
    "ladder": (ladder, "a{half}"),
    "detours": (detours, "s{third}"),
    "grid": (grid, "g{side},{side}"),
    "tree": (tree, "z"),
    "dense": (dense, "s{last}"),
    "tireworld": (tireworld, "at{quarter}"),
}


def network(shape: str, size: int, seed: int = 0) -> ActionNetwork:
    """Return a network of that shape and about that many situations."""
    made, goal = NETWORK_SHAPES[shape]
    rows = list(made(size, random.Random(seed)))
    names = dict.fromkeys(name for s, t, _, _, f in rows for name in (s, t, f) if name)
    side = max(2, round(size**0.5)) - 1
    places = {"last": size - 1, "half": size // 2 - 1, "third": size // 3, "side": side}
    there = goal.format(**places, quarter=max(3, size // 4) - 1)
    actions = [Action(s, t, BOUND_ACTION, cost, tries, fail) for s, t, cost, tries, fail in rows]
    every = [*names, *({there} - names.keys())]
    return ActionNetwork.build(map(Situation, every), actions, every[0], there)


def main() -> None:
    """Print a table."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("size", nargs="*", type=int, default=[100, 1000, 8670])
    sizes: list[int] = words.parse_args().size
    print(f"{'shape':<12}{'situations':>11}{'actions':>9}{'worst cases':>14}{'figures':>14}  what is known")
    for shape in NETWORK_SHAPES:
        for size in sizes:
            made = network(shape, size)
            took, known = zip(*(_timed(item, made) for item in (worst_cases, _figures)), strict=True)
            times = "".join(f"{item:>12.2f} s" for item in took)
            counts = f"{len(made.situations):>11}{len(made.actions):>9}"
            print(f"{shape:<12}{counts}{times}  {'; '.join(known)}", flush=True)


def _figures(made: ActionNetwork) -> object:
    forecaster = Forecaster(made, [Chance(0.9, 0.01)] * len(made.actions))
    return forecaster.forecast(), forecaster.slopes()


def _timed(does: Callable[[ActionNetwork], object], made: ActionNetwork) -> tuple[float, str]:
    begun = time.process_time()
    try:
        does(made)
        known = "all"
    except TooLarge as large:
        known = str(large)
    return time.process_time() - begun, known


if __name__ == "__main__":
    main()
