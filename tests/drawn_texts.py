"""Texts as they are drawn, in figures and in a browser: whether they overlap, or leave the paper."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING, Any

import matplotlib.text
from matplotlib.backends.backend_agg import FigureCanvasAgg

if TYPE_CHECKING:
    from playwright.sync_api import Page

SLACK = 0.5  # [px] by which boxes may touch


def faults_of(figure: Any) -> list[str]:
    """What is wrong with a figure's texts, in words: each pair that overlaps, each that is clipped."""
    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    paper = figure.bbox
    boxes = [
        (text, text.get_window_extent(renderer))
        for text in figure.findobj(matplotlib.text.Text)
        if text.get_text().strip() and _is_drawn(text)
    ]
    clipped = [
        f"{text.get_text()!r} is clipped"
        for text, box in boxes
        if box.x0 < paper.x0 - SLACK
        or box.y0 < paper.y0 - SLACK
        or box.x1 > paper.x1 + SLACK
        or box.y1 > paper.y1 + SLACK
    ]
    overlapping = [
        f"{a.get_text()!r} lies over {b.get_text()!r}"
        for (a, one), (b, other) in combinations(boxes, 2)
        if min(one.x1, other.x1) - max(one.x0, other.x0) > SLACK
        and min(one.y1, other.y1) - max(one.y0, other.y0) > SLACK
    ]
    return clipped + overlapping


def _is_drawn(text: Any) -> bool:
    """Ticks beyond an axis' limits, and those of a hidden axis, are there and not drawn."""
    axes = text.axes
    if not text.get_visible() or (axes is not None and not axes.get_visible()):
        return False
    for axis in (axes.xaxis, axes.yaxis) if axes is not None else ():
        labels = [label for tick in axis.majorTicks + axis.minorTicks for label in (tick.label1, tick.label2)]
        if any(text is label for label in [*labels, axis.label, axis.offsetText]):
            shown = [
                label
                for tick in axis._update_ticks()
                for label in (tick.label1, tick.label2)
                if label.get_visible()
            ]
            of_axis = [*shown, axis.label, axis.offsetText]
            return bool(axes.axison and axis.get_visible() and any(text is item for item in of_axis))
    return True


def faults_of_page(page: Page) -> list[str]:
    """The same of all drawings that a browser shows, and of what is wider than the page."""
    return list(page.evaluate(_FAULTS))


# Boxes reach above and below the letters: by 2 px lines may overlap, and turned texts by 1 px of 10.
_FAULTS = """() => {
    const found = [];
    for (const svg of document.querySelectorAll('svg')) {
        if (svg.parentElement && svg.parentElement.closest('svg')) continue;
        const paper = svg.getBoundingClientRect();
        const texts = [...svg.querySelectorAll('text')]
            .filter(text => text.textContent.trim())
            .map(text => [text.textContent.trim(), text.getBoundingClientRect()])
            .filter(([, box]) => box.width > 0);
        texts.forEach(([words, box], at) => {
            if (box.left < paper.left - 1 || box.right > paper.right + 1
                || box.top < paper.top - 1 || box.bottom > paper.bottom + 1)
                found.push(`${words} is clipped`);
            for (const [others, other] of texts.slice(at + 1)) {
                const wide = Math.min(box.right, other.right) - Math.max(box.left, other.left);
                const high = Math.min(box.bottom, other.bottom) - Math.max(box.top, other.top);
                if (wide > 1 && high > 2) found.push(`${words} lies over ${others}`);
            }
        });
    }
    const wide = document.documentElement.scrollWidth;
    if (document.body && wide > window.innerWidth + 1) found.push(`the page is ${wide} px wide`);
    return found;
}"""
