"""From results to figures; the only place that imports matplotlib."""

from quavsweep.plot.figure import draw

__all__ = ["draw"]
