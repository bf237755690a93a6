"""How far a craft is from the nearest point where it tumbles."""

from quavsweep.margin.find import find_margin
from quavsweep.margin.finding import Margin
from quavsweep.margin.record import write_margin

__all__ = ["Margin", "find_margin", "write_margin"]
