"""All figures and tables, in the paper's order, and what goes past it."""

from __future__ import annotations

from quavsweep.paper.item import Item

ITEMS: tuple[Item, ...] = ()
