"""How far a craft is from the nearest point where it tumbles."""

from quavsweep.margin.find import find_margin
from quavsweep.margin.finding import Margin

__all__ = ["Margin", "find_margin"]
