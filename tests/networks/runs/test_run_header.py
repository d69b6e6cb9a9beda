"""Headers of journals: which network they were written for."""

from __future__ import annotations

from typing import Any

import orjson
import pytest

from handcart.networks.graph.network import ActionNetwork
from handcart.networks.runs.run_header import is_of_network, network_fields
from tests.networks.conftest import Stand


@pytest.fixture
def network(stand: Stand) -> ActionNetwork:
    return stand.network("a b one 1", "b z two 1")


@pytest.fixture
def header(network: ActionNetwork) -> dict[str, Any]:
    """Return the header of an older version, whose primitives had fewer parameters and another
    fingerprint.
    """
    fields = {"network": "of an older version", "plan_on": network_fields(network)}
    read: dict[str, Any] = orjson.loads(orjson.dumps(fields))
    return read


def test_header_of_an_older_version_is_of_the_same_network(
    header: dict[str, Any], network: ActionNetwork
) -> None:
    """Also if primitives read more entries of the world model today."""
    assert is_of_network(header, network)
    uses = header["plan_on"]["keys"].index("uses")
    header["plan_on"]["actions"][0][uses] = ["map"]
    assert is_of_network(header, network)
    assert is_of_network({"network": network.fingerprint()}, network)


@pytest.mark.parametrize("key", ["do", "from", "to", "on_fail", "cost_s", "attempts", "permit", "with"])
def test_header_of_another_network_is_refused(
    header: dict[str, Any], network: ActionNetwork, key: str
) -> None:
    plan_on = header["plan_on"]
    plan_on["actions"][1][plan_on["keys"].index(key)] = "other"
    assert not is_of_network(header, network)


@pytest.mark.parametrize("key", ["start", "goal", "situations", "elements"])
def test_header_with_another_situation_is_refused(
    header: dict[str, Any], network: ActionNetwork, key: str
) -> None:
    header["plan_on"][key] = {"a": "other"}
    assert not is_of_network(header, network)


@pytest.mark.parametrize(
    "plan_on", [None, 3, {}, {"keys": ["do"], "actions": [3]}, {"keys": 1, "actions": []}]
)
def test_damaged_header_is_of_no_network(network: ActionNetwork, plan_on: Any) -> None:
    assert not is_of_network({"network": "other", "plan_on": plan_on}, network)
