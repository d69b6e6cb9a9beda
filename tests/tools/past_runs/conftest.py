"""Runs with scripted ends, for commands that read runs."""

from tests.networks.conftest import new_stand as new_stand
from tests.networks.conftest import primitives as primitives
from tests.networks.past_runs.conftest import scripted_run as scripted_run

TWO_WAYS = """\
format: handcart-task/1
title: Two ways
robot: librarian
start: a
goal: z
situations: {a: {}, b: {}, z: {}}
actions:
  - {do: THINK, from: a, to: b, cost_s: 2, attempts: 2, with: {name: near}}
  - {do: THINK, from: b, to: z, cost_s: 1, with: {name: ahead}}
  - {do: THINK, from: a, to: z, cost_s: 6, with: {name: far}}
"""
