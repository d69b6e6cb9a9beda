"""A network as an SVG picture, without any helper program."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from html import escape
from itertools import pairwise

from handcart.networks.graph.network import ActionNetwork, Situation

from .layout import BOX, Line, Point, lay_out, lines_of

MARGIN = 30.0  # all in [px]
LINE = 15.0
BESIDE = 70.0  # between ways that lead from one box to the same other one

STYLE = """
  text { font: 12px Helvetica, Arial, 'DejaVu Sans', sans-serif; fill: #1d2733 }
  .name { font-weight: 600 }
  .fact { fill: #5b6b7d; font-size: 11px }
  .box { fill: #f4f7fb; stroke: #8aa0b8; stroke-width: 1.2 }
  .start { fill: #e3f0ff; stroke: #2f6fb5; stroke-width: 2 }
  .goal { fill: #e2f5e6; stroke: #2d8a47; stroke-width: 2 }
  .way { fill: none; stroke: #4a5d73; stroke-width: 1.5 }
  .fail { stroke: #c0392b; stroke-dasharray: 5 4 }
  .paper { fill: #fff; fill-opacity: 0.9 }
  .cost { fill: #5b6b7d; font-size: 10.5px }
  .failed { fill: #c0392b; font-size: 10.5px }
"""
ARROWS = """<defs>
  <marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="8" markerHeight="8" orient="auto">
    <path d="M0 0 L8 4 L0 8 z" fill="#4a5d73"/></marker>
  <marker id="failtip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="8" markerHeight="8" orient="auto">
    <path d="M0 0 L8 4 L0 8 z" fill="#c0392b"/></marker>
</defs>"""


def to_svg(network: ActionNetwork) -> str:
    """The network as an SVG document: Success solid with its cost, declared Fail dashed."""
    lines = lines_of(network)
    layout = lay_out(network, lines)
    ways, labels = [], []
    alike = Counter((line.source, line.target) for line in lines)
    seen: Counter[tuple[str, str]] = Counter()
    for line, between in zip(lines, layout.between, strict=True):
        pair = line.source, line.target
        shift = 0.0 if between else BESIDE * (seen[pair] - 0.5 * (alike[pair] - 1))
        seen[pair] += 1
        route = _route(line, between, layout.boxes, network, shift)
        ways.append(_way(line, route))
        labels.append(_label(line, *_middle(route)))
    boxes = [_situation(each, layout.boxes[each.name], network) for each in network.situations.values()]
    frame = _frame([*layout.boxes.values(), *(point for points in layout.between for point in points)])
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {frame}>'
    return "\n".join([head, f"<style>{STYLE}</style>", ARROWS, *ways, *boxes, *labels, "</svg>"]) + "\n"


def _frame(points: Sequence[Point]) -> str:
    left, right = (pick(point.x for point in points) for pick in (min, max))
    bottom = max(point.y for point in points)
    x, y = left - 0.5 * BOX - MARGIN - 40.0, -40.0 - MARGIN
    width, height = right - left + BOX + 2.0 * MARGIN + 80.0, bottom - 2.0 * y
    size = f'viewBox="{x:.0f} {y:.0f} {width:.0f} {height:.0f}" width="{width:.0f}" height="{height:.0f}"'
    return f'{size} style="background: #fff"'


def _half_height(situation: Situation) -> float:
    return 0.5 * (26.0 + LINE * len(situation.facts))


def _situation(situation: Situation, middle: Point, network: ActionNetwork) -> str:
    ends = {network.start: " start", network.goal: " goal"}
    half = _half_height(situation)
    left, top = middle.x - 0.5 * BOX, middle.y - half
    shape = (
        f'<rect class="box{ends.get(situation.name, "")}" x="{left:.1f}" y="{top:.1f}" width="{BOX:.0f}" '
        f'height="{2 * half:.1f}" rx="9"/>'
    )
    words = [_text(middle.x, top + 17.0, situation.name, "name")]
    for number, (key, value) in enumerate(situation.facts.items(), start=1):
        words.append(_text(middle.x, top + 17.0 + LINE * number, f"{key}: {value}", "fact"))
    return "\n".join([shape, *words])


def _route(
    line: Line, between: Sequence[Point], boxes: Mapping[str, Point], network: ActionNetwork, shift: float
) -> list[Point]:
    """From the edge of one box to that of the other, through the lanes between."""
    a, b = boxes[line.source], boxes[line.target]
    half_a, half_b = (_half_height(network.situations[name]) for name in (line.source, line.target))
    if line.source == line.target:
        right = a.x + 0.5 * BOX
        return [Point(right, a.y - 10.0), Point(right + 45.0, a.y), Point(right + 1.0, a.y + 10.0)]
    sign = 1.0 if b.y > a.y else -1.0
    # What leads back leaves and arrives a little aside of what leads on.
    aside = 0.0 if sign > 0 else 0.3 * BOX
    lanes = [Point(p.x, p.y + sign * step) for p in between for step in (-30.0, 30.0)]
    toward = [0.25 * BOX * max(-1.0, min(1.0, (q.x - p.x) / BOX)) for p, q in _ends(a, b, between)]
    leave, arrive = (max(-0.42 * BOX, min(0.42 * BOX, step + aside + shift)) for step in toward)
    first = Point(a.x + leave, a.y + sign * half_a)
    last = Point(b.x + arrive, b.y - sign * (half_b + 2.0))
    return [first, *lanes, last]


def _ends(a: Point, b: Point, between: Sequence[Point]) -> tuple[tuple[Point, Point], tuple[Point, Point]]:
    """Each box with what the way passes next to it."""
    return (a, between[0] if between else b), (b, between[-1] if between else a)


def _way(line: Line, route: Sequence[Point]) -> str:
    kind, tip = ("way fail", "failtip") if line.failed else ("way", "tip")
    path = [f"M{route[0].x:.1f} {route[0].y:.1f}"]
    for p, q in pairwise(route):
        bend = 0.5 * (q.y - p.y)
        path.append(f"C{p.x:.1f} {p.y + bend:.1f} {q.x:.1f} {q.y - bend:.1f} {q.x:.1f} {q.y:.1f}")
    return f'<path class="{kind}" d="{" ".join(path)}" marker-end="url(#{tip})"/>'


def _middle(route: Sequence[Point]) -> tuple[float, float]:
    if len(route) == 3:
        return route[1].x, route[1].y
    before, after = route[(len(route) - 1) // 2], route[len(route) // 2]
    return 0.5 * (before.x + after.x), 0.5 * (before.y + after.y)


def _label(line: Line, x: float, y: float) -> str:
    if line.failed:
        words = [(f"{line.action.do} fails", "failed", 4.0)]
    elif line.action.binding is None:
        words = [(line.action.do, "cost", 4.0)]
    else:
        words = [(line.action.do, "", -2.0), (f"{line.action.cost_s:g} s", "cost", 11.0)]
    half_width, half_height = 3.6 * max(len(word) for word, _, _ in words) + 3.0, 7.5 * len(words)
    paper = f'<rect class="paper" x="{x - half_width:.1f}" y="{y - half_height:.1f}" '
    size = f'width="{2 * half_width:.1f}" height="{2 * half_height:.1f}"/>'
    return "\n".join([paper + size, *(_text(x, y + down, word, kind) for word, kind, down in words)])


def _text(x: float, y: float, words: str, kind: str) -> str:
    return f'<text class="{kind}" x="{x:.1f}" y="{y:.1f}" text-anchor="middle">{escape(words)}</text>'
