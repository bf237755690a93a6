"""All figures and tables, in the paper's order, and what goes past it."""

from __future__ import annotations

from quavsweep.paper import figure_05, figure_06, figure_07, figure_09, figure_10
from quavsweep.paper.item import Item

ITEMS: tuple[Item, ...] = (
    figure_05.FIGURE,
    figure_06.FIGURE,
    figure_07.FIGURE,
    figure_09.FIGURE,
    figure_10.FIGURE,
)
