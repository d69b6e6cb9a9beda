"""Drawing a network into a file: as Mermaid, dot, SVG, PNG or PDF."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from handcart.networks.graph.network import ActionNetwork

from .folded_network import FoldedNetwork, RepeatedPart, Spot, fold
from .network_picture import draw_network


def to_mermaid(network: ActionNetwork, title: str = "") -> str:
    """Return the network as a Mermaid flowchart, with a box for each situation and an arrow for each action.

    Dotted arrows lead to the situations after Fails, if the task file names any. A part of the network that
    the file repeats for several elements has a frame.
    """
    folded = fold(network)
    number = _numbers(folded)
    lines = ["flowchart LR"]
    for part, spot in _nested(folded, None):
        if spot is None:
            named = (
                f' {_escaped_for_mermaid(number[part])}["{_escaped_for_mermaid(part.title)}"]' if part else ""
            )
            lines.append(f"    subgraph{named}" if part else "    end")
            continue
        ends = ("([", "])") if spot in (folded.start, folded.goal) else ("[", "]")
        words = "<br/>".join(map(_escaped_for_mermaid, (spot.name, *spot.facts)))
        lines.append(f'    {number[spot]}{ends[0]}"{words}"{ends[1]}')
    for way in folded.ways:
        label = "<br/>".join(map(_escaped_for_mermaid, (f"{way.do} {way.costs}".strip(), *way.parameters)))
        lines.append(f'    {number[way.source]} -->|"{label}"| {number[way.target]}')
        if way.on_fail:
            lines.append(f'    {number[way.source]} -.->|"{way.do} fails"| {number[way.on_fail]}')
        for cause, to in way.fails:
            lines.append(
                f'    {number[way.source]} -.->|"{way.do} fails: {_escaped_for_mermaid(cause)}"| {number[to]}'
            )
    return "\n".join(lines) + "\n"


def to_dot(network: ActionNetwork, title: str = "") -> str:
    """Return the network in the language of Graphviz (DOT), with repeated parts as clusters."""
    folded = fold(network)
    number = _numbers(folded)
    newline = chr(92) + "n"
    lines = ["digraph network {", "    rankdir=LR;", "    node [shape=box, style=rounded, fontname=sans];"]
    lines.append("    edge [fontname=sans, fontsize=10];")
    for part, spot in _nested(folded, None):
        if spot is None:
            named = (
                f'    subgraph cluster_{number[part]} {{ label="{_escaped(part.title)}";' if part else "    }"
            )
            lines.append(named)
            continue
        thick = ", penwidth=2" if spot in (folded.start, folded.goal) else ""
        words = newline.join(map(_escaped, (spot.name, *spot.facts)))
        lines.append(f'    {number[spot]} [label="{words}"{thick}];')
    for way in folded.ways:
        label = newline.join(map(_escaped, (f"{way.do} {way.costs}".strip(), *way.parameters)))
        lines.append(f'    {number[way.source]} -> {number[way.target]} [label="{label}"];')
        if way.on_fail:
            dashed = f'label="{way.do} fails", style=dashed'
            lines.append(f"    {number[way.source]} -> {number[way.on_fail]} [{dashed}];")
        for cause, to in way.fails:
            dashed = f'label="{way.do} fails: {_escaped(cause)}", style=dashed'
            lines.append(f"    {number[way.source]} -> {number[to]} [{dashed}];")
    return "\n".join([*lines, "}"]) + "\n"


def to_svg(network: ActionNetwork, title: str = "") -> str:
    """Return a drawing of the network, below its title, as an SVG document."""
    from .svg import to_svg as written

    return written(draw_network(network, title=title))


def to_png(network: ActionNetwork, title: str = "") -> bytes:
    """Return a drawing of the network, below its title, as the bytes of a PNG file."""
    from .figure import to_png as written

    return written(draw_network(network, title=title))


def to_pdf(network: ActionNetwork, title: str = "") -> bytes:
    """Return the drawing of a network, below its title, as the bytes of a PDF file of one page."""
    from .figure import to_pdf as written

    return written(draw_network(network, title=title))


WRITER_BY_SUFFIX: dict[str, Callable[[ActionNetwork, str], str | bytes]] = {
    ".svg": to_svg,
    ".png": to_png,
    ".pdf": to_pdf,
    ".mmd": to_mermaid,
    ".dot": to_dot,
}
"""Writers of a network by file suffix; each takes the network and the task's title."""


def _numbers(folded: FoldedNetwork) -> dict[Spot | RepeatedPart | None, str]:
    spots: dict[Spot | RepeatedPart | None, str] = {
        spot: f"n{number}" for number, spot in enumerate(folded.spots)
    }
    return spots | {part: f"p{number}" for number, part in enumerate(folded.parts)}


def _nested(
    folded: FoldedNetwork, part: RepeatedPart | None
) -> Iterator[tuple[RepeatedPart | None, Spot | None]]:
    """Yield the situations of a part, then those of the parts within it; None, None closes a part."""
    for spot in folded.spots:
        if folded.part_of[spot] is part:
            yield None, spot
    for item in folded.parts:
        if item.around is part:
            yield item, None
            yield from _nested(folded, item)
            yield None, None


def _escaped(words: str) -> str:
    return words.replace("&", "&amp;").replace('"', "&quot;").replace("\\", "\\\\")


def _escaped_for_mermaid(words: str) -> str:
    """Return text for a label of Mermaid, which reads `#35;` as an entity and tags as HTML."""
    escaped = words.replace("#", "#35;").replace("&", "&amp;").replace('"', "&quot;")
    return escaped.replace("<", "&lt;").replace(">", "&gt;")
