"""All figures and tables, in the paper's order, and what goes past it."""

from __future__ import annotations

from quavsweep.paper import (
    figure_03,
    figure_04,
    figure_05,
    figure_06,
    figure_07,
    figure_08,
    figure_09,
    figure_10,
    figure_11,
    figure_12,
    figure_13,
    given,
    margin,
    remark_3,
    table_1,
    table_2,
    table_3,
)
from quavsweep.paper.item import Item

ITEMS: tuple[Item, ...] = (
    given.ITEM,
    table_1.FIGURE,
    table_2.TABLE,
    figure_03.FIGURE,
    figure_04.FIGURE,
    figure_05.FIGURE,
    figure_06.FIGURE,
    figure_07.FIGURE,
    figure_08.FIGURE,
    table_3.FIGURE,
    figure_09.FIGURE,
    figure_10.FIGURE,
    figure_11.FIGURE,
    figure_12.FIGURE,
    figure_13.FIGURE,
    remark_3.FIGURE,
    margin.FIGURE,
)
