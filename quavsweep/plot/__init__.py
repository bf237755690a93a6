"""From results to figures; the only place that imports matplotlib."""

import logging

# Where the home folder cannot be written, matplotlib warns of its cache when it is imported: no news to a user.
_log = logging.getLogger("matplotlib")
_level = _log.level
_log.setLevel(logging.ERROR)

from quavsweep.plot.figure import draw, draw_point, make_figure, picture, save_figure  # noqa: E402  behind the silence
from quavsweep.plot.point import make_point_figure  # noqa: E402

_log.setLevel(_level)

__all__ = ["draw", "draw_point", "make_figure", "make_point_figure", "picture", "save_figure"]
