"""What overlaps in a figure: texts with texts, and texts with the panels of others."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from quavsweep.plot.style import style

SLACK = 1.0  # pixels at 100 per inch


def drawn(figure: Figure) -> Figure:
    """Lay a figure out as when it is written."""
    with style():
        FigureCanvasAgg(figure).draw()
    return figure


def texts(figure: Figure) -> list[tuple[Axes | None, Text, Bbox]]:
    """Return all texts that are seen, with the axes to which they belong and where they are."""
    found = [(None, text) for text in figure.texts]
    found += [(None, figure._suptitle)] if figure._suptitle else []
    found += [(None, text) for legend in figure.legends for text in legend.get_texts()]
    for axes in figure.axes:
        found += [(axes, text) for text in _texts_of(axes)]
    unique = {id(text): (axes, text) for axes, text in found if text.get_visible() and text.get_text().strip()}
    return [(axes, text, text.get_window_extent()) for axes, text in unique.values()]


def _texts_of(axes: Axes) -> Iterator[Text]:
    yield from axes.texts
    if axes.get_legend():
        yield from [*axes.get_legend().get_texts(), axes.get_legend().get_title()]
    if not _has_ticks(axes):
        return
    yield from (axes.title, axes.xaxis.label, axes.yaxis.label)
    for axis in (axes.xaxis, axes.yaxis, *([axes.zaxis] if hasattr(axes, "zaxis") else [])):
        yield from _tick_labels(axis)
        yield axis.get_offset_text()


def _has_ticks(axes: Axes) -> bool:
    return axes.axison or axes.name == "3d"


def _tick_labels(axis: Axis) -> Iterator[Text]:
    low, high = sorted(axis.get_view_interval())
    room = 1e-9 * (high - low)
    for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
        if low - room <= tick.get_loc() <= high + room:
            yield tick.label1


def overlaps(figure: Figure) -> list[str]:
    """Return what overlaps, or lies outside of the figure, in words."""
    seen = texts(drawn(figure))
    found = [
        f"{a.get_text()!r} and {b.get_text()!r}"
        for (first_of, a, first), (second_of, b, second) in combinations(seen, 2)
        if _meet(first, second) and (first_of is not second_of or not (_slanted(a) or _slanted(b)))
    ]
    for owner, text, box in seen:
        if not _inside(box, figure.bbox):
            found.append(f"{text.get_text()!r} outside")
        for axes in figure.axes:
            if axes is not owner and axes.axison and _meet(box, axes.get_window_extent()):
                found.append(f"{text.get_text()!r} on a panel")
    return found


def smallest(figure: Figure) -> float:
    """Return the size of the smallest text, in points."""
    return min(text.get_fontsize() for _, text, _ in texts(drawn(figure)))


def _slanted(text: Text) -> bool:
    """Whether a text runs along an axis in space, so that its upright frame says little."""
    return text.get_rotation() % 90 != 0


def _meet(a: Bbox, b: Bbox) -> bool:
    return min(a.x1, b.x1) - max(a.x0, b.x0) > SLACK and min(a.y1, b.y1) - max(a.y0, b.y0) > SLACK


def _inside(a: Bbox, b: Bbox) -> bool:
    return a.x0 >= b.x0 - SLACK and a.y0 >= b.y0 - SLACK and a.x1 <= b.x1 + SLACK and a.y1 <= b.y1 + SLACK
