"""The events of a YAML parser: libyaml's where it reads as ruamel.yaml does, which takes 30 times as long."""

import re
from collections.abc import Iterator
from typing import Any

import yaml
from ruamel.yaml import YAML

# libyaml follows YAML 1.1: other line breaks, tabs where 1.2 has none, other words behind these signs.
_READ_DIFFERENTLY = re.compile("[\t\r\x85\u2028\u2029\ufeff&*!%?]")


def fast_events(text: str) -> Iterator[Any] | None:
    """The events of `text` by libyaml; None where it isn't there, or might read something else.

    Raises yaml.YAMLError, on the way, where libyaml takes it for no YAML; `exact_events` has the last word.
    """
    if not hasattr(yaml, "CLoader") or _READ_DIFFERENTLY.search(text):
        return None
    return iter(yaml.parse(text, Loader=yaml.CLoader))


def exact_events(text: str) -> Iterator[Any]:
    """The events of `text` as YAML 1.2 has them; raises ruamel.yaml.error.YAMLError on the way."""
    return iter(YAML(typ="safe", pure=True).parse(text))
