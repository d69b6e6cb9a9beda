"""Names of users, written as words of YAML and read back."""

from __future__ import annotations

import pytest
import yaml

from handcart.files.yaml.yaml_document import parse_document
from handcart.files.yaml.yaml_word import yaml_word

PLAIN = ("plan.pgm", "maps/plan-2.pgm", "Move 2 boxes", "table_1")
QUOTED = (
    "lab #2.pgm", "a: b", "a:", "#1", "- a", "[a]", "{a}", "a, b", "'a'",
    'say "a"', "back\\slash", " a", "a ", "a  b",
    "", "yes", "null", "12", "1e3", "1:30", "2024-01-01", "*a", "&a", "!a", "%a", "@a", "`a", "|", ">", "?",
    "<<",
    "line\nbreak", "tab\there", "\x85", "\x7f", "größe.pgm", "\u2028", "\ufeffa", "😀",
)  # fmt: skip


@pytest.mark.parametrize("text", [*PLAIN, *QUOTED])
def test_a_text_is_read_back_as_it_was(text: str) -> None:
    written = f"a: {yaml_word(text)}\nb: {{c: {yaml_word(text)}, d: [{yaml_word(text)}]}}\n"
    expected = {"a": text, "b": {"c": text, "d": [text]}}
    assert parse_document(written.encode(), "a.yaml").data == expected
    assert yaml.safe_load(written) == expected  # YAML 1.1, as ROS reads maps


@pytest.mark.parametrize("text", PLAIN)
def test_a_usual_name_has_no_quotes(text: str) -> None:
    assert yaml_word(text) == text
