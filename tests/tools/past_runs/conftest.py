"""Runs with scripted ends, for commands that read them."""

from tests.networks.conftest import new_stand as new_stand
from tests.networks.conftest import primitives as primitives
from tests.networks.past_runs.conftest import scripted_run as scripted_run
