"""All figures and tables, in the paper's order, and what goes past it."""

from __future__ import annotations

from quavsweep.paper import figure_05, figure_06, figure_07, figure_09, figure_10, figure_11, figure_12, table_2
from quavsweep.paper.item import Item

ITEMS: tuple[Item, ...] = (
    table_2.TABLE,
    figure_05.FIGURE,
    figure_06.FIGURE,
    figure_07.FIGURE,
    figure_09.FIGURE,
    figure_10.FIGURE,
    figure_11.FIGURE,
    figure_12.FIGURE,
)
