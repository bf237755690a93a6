"""All figures and tables, in the paper's order, and what goes past it."""

from __future__ import annotations

from quavsweep.paper import figure_03, table_1, table_3
from quavsweep.paper.item import Item

ITEMS: tuple[Item, ...] = (table_1.FIGURE, figure_03.FIGURE, table_3.FIGURE)
