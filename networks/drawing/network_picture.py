"""A network as boxes, links and frames on paper, used by all views of networks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

from handcart.networks.graph.network import ActionNetwork

from .folded_network import FoldedAction, FoldedNetwork, RepeatedPart, Spot, fold, shortened
from .layers import GAP, Key, LayerEdge, Point, Size, lay_out
from .text_width import text_width

NAME, SMALL = 12.0, 11.0  # sizes of letters, all in [px]
LINE, PAD, LEAST, MARGIN = 16.0, 9.0, 60.0, 14.0
LINE_WIDTH_RATIO = 1.05  # share by which a long line may be wider than estimated
OUTCOME_WORDS = {"Success": "Success", "Fail": "Fail", "GiveUp": "GiveUp", "": "no end"}
LEGEND_LINES = (
    "Rounded: situations with their facts. Square: actions with cost and parameters.",
    "Dashed: where a Fail leads whose knowledge differs; any other Fail leaves the situation as it is.",
    "Framed: done once for each element.",
)


class Text(NamedTuple):
    """A line of text in a drawing; x is its middle, or its left end if not `centred`; y is its base line; in
    [px].
    """

    x: float
    y: float
    words: str
    size: float
    bold: bool = False
    centred: bool = True

    @property
    def width(self) -> float:
        """Width of the text, in [px]."""
        return text_width(self.words, self.size, bold=self.bold)

    @property
    def left(self) -> float:
        """Left end of the text, in [px]."""
        return self.x - 0.5 * self.width if self.centred else self.x


class DrawnBox(NamedTuple):
    """Box of a situation or an action in a drawing; x and y are its upper left corner, in [px]."""

    x: float
    y: float
    width: float
    height: float
    kind: str
    """`start`, `goal`, `situation`, or of an action `travelled`, `failed`, `mixed`, `untried`."""
    texts: tuple[Text, ...]
    is_of: Spot | FoldedAction


class DrawnFrame(NamedTuple):
    """Frame around a part of a drawn network that is copied for each element of a list (`repeat` in the
    task's file).
    """

    x: float
    y: float
    width: float
    height: float
    title: Text


class DrawnLink(NamedTuple):
    """Line that joins the box of an action to a situation in a drawing, with alternately straight and curved
    segments.
    """

    points: tuple[Point, ...]
    travelled: bool
    failed: bool
    """True if a Fail leads along the link."""
    arrow: bool

    def curves(self) -> Iterator[tuple[Point, Point, Point]]:
        """Yield for each segment of the link's curve (cubic Bézier) its two control points and its end."""
        for number, (p, q) in enumerate(pairwise(self.points)):
            if number % 2 == 0:
                yield p, q, q
                continue
            turn = 1.0 if number == 1 else -1.0  # back over itself: out on the right, in on the left
            bend = turn * 0.5 * GAP if p.x == q.x else 0.5 * (q.x - p.x)
            yield Point(p.x + bend, p.y), Point(q.x + (bend if p.x == q.x else -bend), q.y), q


@dataclass(frozen=True)
class NetworkPicture:
    """A drawn network, in [px]; the upper left corner is the origin, y points down."""

    width: float
    height: float
    frames: Sequence[DrawnFrame]
    boxes: Sequence[DrawnBox]
    links: Sequence[DrawnLink]
    words: Sequence[Text] = ()
    """Title and legend."""

    @property
    def texts(self) -> list[Text]:
        """All texts of the picture: title, legend, titles of frames, and texts in boxes."""
        inside = [text for box in self.boxes for text in box.texts]
        return [*self.words, *(frame.title for frame in self.frames), *inside]

    def box(self, situation: str | None = None, action: int | None = None) -> DrawnBox:
        """Return the box of a situation by its name in the network, or of an action by its number."""
        member: str | int | None = situation if action is None else action
        return next(item for item in self.boxes if member in item.is_of.members)


def draw_network(
    network: ActionNetwork, ended: Iterable[tuple[int, str]] | None = None, title: str | None = None
) -> NetworkPicture:
    """Lay a network out from left to right, with copies of repeated parts drawn as one framed part.

    Args:
        network: a task's network, or one kept in a journal.
        ended: number in the network and outcome of each action of a run, the outcome empty if the action
            has no end; None: no run is drawn.
        title: title above the drawing, which then also has a legend below; None: neither.
    """
    folded = fold(network)
    drawn = _Drawing(folded, None if ended is None else Counter(ended)).part(None)
    head = [] if title is None else [Text(MARGIN, MARGIN + NAME, shortened_to(title), 15.0, True, False)]
    top = MARGIN + (LINE + 2 * PAD if head else 0.0)
    moved = drawn.moved(MARGIN, top)
    legend = () if title is None else LEGEND_LINES
    feet = [
        Text(MARGIN, top + drawn.height + LINE * number + PAD, words, SMALL, False, False)
        for number, words in enumerate(legend, start=1)
    ]
    width = max([drawn.width, *(LINE_WIDTH_RATIO * text.width for text in (*head, *feet))]) + 2 * MARGIN
    height = top + drawn.height + MARGIN + (LINE * len(legend) + PAD if legend else 0.0)
    return NetworkPicture(width, height, moved.frames, moved.boxes, moved.links, [*head, *feet])


def shortened_to(words: str, most: int = 120) -> str:
    """Return a title on one line, cut to `most` characters."""
    line = "".join(letter if letter.isprintable() else "\ufffd" for letter in " ".join(words.split()))
    return line if len(line) <= most else f"{line[: most - 1]}…"


class _Exit(NamedTuple):
    """Point at which links leave a repeated part, by the situation that they lead to."""

    target: Spot
    failed: bool


@dataclass(frozen=True)
class _Drawn:
    """A part, from its own upper left corner."""

    width: float
    height: float
    enter: float
    exits: Mapping[_Exit, tuple[float, bool]]
    """Distance below the upper edge of each exit, in [px], and whether a run took it."""
    frames: Sequence[DrawnFrame]
    boxes: Sequence[DrawnBox]
    links: Sequence[DrawnLink]

    def moved(self, x: float, y: float) -> _Drawn:
        return _Drawn(
            self.width,
            self.height,
            self.enter,
            self.exits,
            [f._replace(x=f.x + x, y=f.y + y, title=_moved(f.title, x, y)) for f in self.frames],
            [
                b._replace(x=b.x + x, y=b.y + y, texts=tuple(_moved(text, x, y) for text in b.texts))
                for b in self.boxes
            ],
            [
                link._replace(points=tuple(Point(p.x + x, p.y + y) for p in link.points))
                for link in self.links
            ],
        )


def _moved(text: Text, x: float, y: float) -> Text:
    return text._replace(x=text.x + x, y=text.y + y)


class _Drawing:
    """Drawing of all parts of a network, inner parts first."""

    def __init__(self, folded: FoldedNetwork, ended: Counter[tuple[int, str]] | None) -> None:
        self._folded, self._ended = folded, ended

    def part(self, part: RepeatedPart | None) -> _Drawn:
        """Return the drawing of a repeated part, or with None of everything outside repeated parts."""
        folded = self._folded
        inner = {item: self.part(item) for item in folded.parts if item.around is part}
        boxes = {spot: self._spot(spot) for spot in folded.spots if folded.part_of[spot] is part}
        ways = {way: self._way(way) for way in folded.ways if folded.part_of[way.source] is part}
        sizes: dict[Key, Size] = {
            key: Size(box.width, box.height, box.height / 2) for key, box in [*boxes.items(), *ways.items()]
        }
        sizes |= {name: Size(drawn.width, drawn.height, drawn.enter) for name, drawn in inner.items()}
        edges, kinds = self._edges(part, list(ways), inner, sizes)
        exits = {edge.target: None for edge in edges if isinstance(edge.target, _Exit)}
        sizes |= dict.fromkeys(exits, Size(0.0, 12.0, 6.0))
        first = self._inside(self._entry(part), part)
        laid = lay_out(sizes, edges, first)
        links = [
            DrawnLink(tuple(route), *kind, not isinstance(edge.target, _Exit | RepeatedPart))
            for edge, kind, route in zip(edges, kinds, laid.routes, strict=True)
        ]
        gone: dict[_Exit, tuple[float, bool]] = {}
        for leaving in exits:
            assert isinstance(leaving, _Exit)
            corner = laid.corners[leaving]
            travelled = any(
                travelled for edge, (travelled, _) in zip(edges, kinds, strict=True) if edge.target == leaving
            )
            gone[leaving] = corner.y + 6.0, travelled
            ends = (Point(corner.x, corner.y + 6.0), Point(laid.width, corner.y + 6.0))
            links.append(DrawnLink(ends, travelled, leaving.failed, False))
        enter = laid.corners[first].y + sizes[first].enter
        if part is not None:
            tried = any(link.travelled for link in links)
            ends = (Point(0.0, enter), Point(laid.corners[first].x, enter))
            links.append(DrawnLink(ends, tried, False, not isinstance(first, RepeatedPart)))
        drawn = _Drawn(
            laid.width,
            laid.height,
            enter,
            gone,
            [],
            [_set(box, laid.corners[key]) for key, box in [*boxes.items(), *ways.items()]],
            links,
        )
        within = [item.moved(*laid.corners[key]) for key, item in inner.items()]
        return _framed(_together(drawn, within), part)

    def _edges(
        self,
        part: RepeatedPart | None,
        ways: Sequence[FoldedAction],
        inner: Mapping[RepeatedPart, _Drawn],
        sizes: Mapping[Key, Size],
    ) -> tuple[list[LayerEdge], list[tuple[bool, bool]]]:
        """Return the links of a part, and whether each was travelled and whether a Fail leads along it."""
        edges: list[LayerEdge] = []
        kinds: list[tuple[bool, bool]] = []
        for way in ways:
            middle, came, failed = sizes[way].height / 2, self._count(way, "Success"), self._tried(way)
            edges.append(LayerEdge(self._inside(way.source, part), way, sizes[way.source].height / 2))
            kinds.append((failed > 0, False))
            edges.append(LayerEdge(way, self._target(way.target, part, failed=False), middle))
            kinds.append((came > 0, False))
            spots = [way.on_fail, *(to for _, to in way.fails)]
            for spot in dict.fromkeys(item for item in spots if item is not None):
                below = middle + 0.3 * sizes[way].height
                edges.append(LayerEdge(way, self._target(spot, part, failed=True), below))
                kinds.append((self._count(way, "Fail") > 0, True))
        for name, drawn in inner.items():
            for leaving, (down, travelled) in drawn.exits.items():
                edges.append(LayerEdge(name, self._target(leaving.target, part, failed=leaving.failed), down))
                kinds.append((travelled, leaving.failed))
        return edges, kinds

    def _target(self, spot: Spot, part: RepeatedPart | None, *, failed: bool) -> Key:
        inside = self._inside(spot, part)
        return _Exit(spot, failed) if inside is None else inside

    def _inside(self, spot: Spot, part: RepeatedPart | None) -> Key:
        """Return the box that represents a situation in the drawing of a part; None if it is outside."""
        around = self._folded.part_of[spot]
        if around is part:
            return spot
        while around is not None and around.around is not part:
            around = around.around
        return around

    def _entry(self, part: RepeatedPart | None) -> Spot:
        """Return the situation in which a part begins."""
        folded = self._folded
        if part is None:
            return folded.start
        inside = [spot for spot in folded.spots if self._within(spot, part)]
        came = [w.target for w in folded.ways if w.target in inside and w.source not in inside]
        return folded.start if folded.start in inside else [*came, *inside][0]

    def _within(self, spot: Spot, part: RepeatedPart) -> bool:
        around = self._folded.part_of[spot]
        while around is not None and around is not part:
            around = around.around
        return around is part

    def _spot(self, spot: Spot) -> DrawnBox:
        kind = {self._folded.start: "start", self._folded.goal: "goal"}.get(spot, "situation")
        return _box(kind, spot.name, spot.facts, spot)

    def _way(self, way: FoldedAction) -> DrawnBox:
        below = [way.costs] if way.costs else []
        below += way.parameters
        if self._ended is not None:
            counts = [
                f"{self._count(way, end)} {said}"
                for end, said in OUTCOME_WORDS.items()
                if self._count(way, end)
            ]
            below.append(", ".join(counts) or "not tried")
        return _box(self._kind(way), way.do, below, way)

    def _kind(self, way: FoldedAction) -> str:
        went, tried = self._count(way, "Success"), self._tried(way)
        if not tried:
            return "untried" if self._ended is not None else "action"
        return "travelled" if went == tried else "mixed" if went else "failed"

    def _tried(self, way: FoldedAction) -> int:
        return sum(self._count(way, end) for end in OUTCOME_WORDS)

    def _count(self, way: FoldedAction, outcome: str) -> int:
        return sum(self._ended[number, outcome] for number in way.members) if self._ended else 0


def _box(kind: str, name: str, below: Sequence[str], is_of: Spot | FoldedAction) -> DrawnBox:
    lines = [Text(0.0, 0.0, shortened(name), NAME, True)]
    lines += [Text(0.0, 0.0, shortened(words), SMALL) for words in below]
    width = max(LEAST, max(line.width for line in lines) + 2 * PAD)
    texts = tuple(line._replace(x=width / 2, y=PAD + 10.0 + LINE * row) for row, line in enumerate(lines))
    return DrawnBox(0.0, 0.0, width, LINE * len(lines) + 2 * PAD - 2.0, kind, texts, is_of)


def _set(box: DrawnBox, corner: Point) -> DrawnBox:
    texts = tuple(_moved(text, *corner) for text in box.texts)
    return box._replace(x=corner.x, y=corner.y, texts=texts)


def _together(drawn: _Drawn, within: Iterable[_Drawn]) -> _Drawn:
    every = [drawn, *within]
    return _Drawn(
        drawn.width,
        drawn.height,
        drawn.enter,
        drawn.exits,
        [frame for item in every for frame in item.frames],
        [box for item in every for box in item.boxes],
        [link for item in every for link in item.links],
    )


def _framed(drawn: _Drawn, part: RepeatedPart | None) -> _Drawn:
    """Return the drawing of a part with its frame, and the title above the content."""
    if part is None:
        return drawn
    title = Text(PAD, PAD + 10.0, part.title, SMALL, True, False)
    above, width = LINE + 2 * PAD, max(drawn.width, title.width + 2 * PAD)
    height = above + drawn.height + PAD
    lower = drawn.moved(0.0, above)
    exits = {leaving: (down + above, travelled) for leaving, (down, travelled) in drawn.exits.items()}
    longer = [
        link._replace(points=(*link.points[:-1], Point(width, link.points[-1].y)))
        if link.points[-1].x == drawn.width
        else link
        for link in lower.links
    ]
    frame = DrawnFrame(0.0, 0.0, width, height, title)
    return _Drawn(width, height, drawn.enter + above, exits, [frame, *lower.frames], lower.boxes, longer)
