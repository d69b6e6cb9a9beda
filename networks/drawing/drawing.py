"""Drawing a network: as Mermaid, as dot, and as SVG."""

from __future__ import annotations

from collections.abc import Callable

from handcart.networks.graph.network import ActionNetwork, Situation

from .svg import to_svg as to_svg


def to_mermaid(network: ActionNetwork) -> str:
    """The network as a Mermaid flowchart: Success solid, declared Fail dotted."""
    number = _numbers(network)
    lines = ["flowchart TD"]
    for each in network.situations.values():
        ends = ("([", "])") if each.name in (network.start, network.goal) else ("[", "]")
        lines.append(f'    {number[each.name]}{ends[0]}"{_escaped(each, "<br/>")}"{ends[1]}')
    for action in network.actions:
        source, label = number[action.source], f"{action.do} {action.cost_s:g} s"
        lines.append(f'    {source} -->|"{label}"| {number[action.target]}')
        if action.on_fail:
            lines.append(f'    {source} -.->|"{action.do} fails"| {number[action.on_fail]}')
    return "\n".join(lines) + "\n"


def to_dot(network: ActionNetwork) -> str:
    """The network in the language of Graphviz."""
    number = _numbers(network)
    lines = ["digraph network {", "    node [shape=box, style=rounded, fontname=sans];"]
    lines.append("    edge [fontname=sans, fontsize=10];")
    for each in network.situations.values():
        thick = ", penwidth=2" if each.name in (network.start, network.goal) else ""
        lines.append(f'    {number[each.name]} [label="{_escaped(each, chr(92) + "n")}"{thick}];')
    for action in network.actions:
        source, label = number[action.source], f"{action.do} {action.cost_s:g} s"
        lines.append(f'    {source} -> {number[action.target]} [label="{label}"];')
        if action.on_fail:
            dashed = f'label="{action.do} fails", style=dashed'
            lines.append(f"    {source} -> {number[action.on_fail]} [{dashed}];")
    return "\n".join([*lines, "}"]) + "\n"


FORMATS: dict[str, Callable[[ActionNetwork], str]] = {".mmd": to_mermaid, ".dot": to_dot, ".svg": to_svg}
"""How a network is written, by a file's suffix."""


def _numbers(network: ActionNetwork) -> dict[str, str]:
    return {name: f"n{number}" for number, name in enumerate(network.situations)}


def _escaped(situation: Situation, newline: str) -> str:
    facts = [f"{key}: {value}" for key, value in situation.facts.items()]
    words = (line.replace("&", "&amp;").replace('"', "&quot;") for line in (situation.name, *facts))
    return newline.join(word.replace("\\", "\\\\") for word in words)
