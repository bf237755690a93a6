"""Two results beside each other: which cells changed region, how far exponents moved, and what else differs."""

from quavsweep.difference.common import Common, find_common
from quavsweep.difference.compare import Change, Difference, compare, compare_results, told_of_files
from quavsweep.difference.move import Move, Moved

__all__ = [
    "Change",
    "Common",
    "Difference",
    "Move",
    "Moved",
    "compare",
    "compare_results",
    "find_common",
    "told_of_files",
]
