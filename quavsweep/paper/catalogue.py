"""All figures and tables, in the paper's order, and what goes past it."""

from __future__ import annotations

from quavsweep.paper import figure_04, figure_08, figure_13
from quavsweep.paper.item import Item

ITEMS: tuple[Item, ...] = (figure_04.FIGURE, figure_08.FIGURE, figure_13.FIGURE)
