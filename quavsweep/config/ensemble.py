"""The axis `ensemble`: starts drawn from (seed, index), and what it must fulfil."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from quavsweep.config.place import Keys, Place
from quavsweep.config.schema import ENSEMBLE, Config
from quavsweep.grid import Axis
from quavsweep.models import Model
from quavsweep.nearest import nearest

BOX: Keys = ("axes", ENSEMBLE, "box")
EFFORT: Keys = ("effort",)
BLOCK = 4  # words that Philox makes of one value of its counter


def make_ensemble(num: int, seed: int, box: Mapping[str, Sequence[float]], states: Sequence[str]) -> Axis:
    """Return the axis of some starts.

    Parameters
    ----------
    num : int
        Number of starts.
    seed : int
    box : mapping
        From a state to the interval [low, high) from which it is drawn.
    states : sequence of str
        Names of all states, in the model's order.

    Notes
    -----
    The counter-based generator Philox4x64-10 [1]_ with the key `seed` makes a stream of words. Start k owns a whole
    number of counters, with a word for each state of the model, drawn or not; so it depends neither on `num` nor on
    the other states in the box. The upper 53 bits of a word are the place in the interval.

    References
    ----------
    .. [1] J. K. Salmon, M. A. Moraes, R. O. Dror, D. E. Shaw, Proc. SC11, 16 (2011).
    """
    words = -(-len(states) // BLOCK) * BLOCK
    drawn = np.random.Philox(key=seed).random_raw(num * words).reshape(num, words)
    place = (drawn >> np.uint64(11)) * 2.0**-53
    along = [(n, box[n][0] + (box[n][1] - box[n][0]) * place[:, i]) for i, n in enumerate(states) if n in box]
    return Axis(ENSEMBLE, tuple(range(num)), tuple((name, tuple(values.tolist())) for name, values in along))


def check_ensemble(config: Config, model: Model, place: Place) -> None:
    """Refuse an ensemble that is not the last axis, a box that is none, and effort.

    With effort undecided starts would go on while those known to be chaotic would not: survival beyond the end would
    be that of a selection.

    Raises
    ------
    ConfigError
        For the first thing that is wrong.
    """
    if config.ensemble is None:
        return
    last = list(config.axes)[-1]
    if last != ENSEMBLE:
        what = f"comes before {place.other(('axes', last), ('axes', ENSEMBLE))}"
        raise place.error(("axes", ENSEMBLE), what, "it must be the last axis")
    if config.effort is not None:
        what = f"is not for {place.other(('axes', ENSEMBLE), EFFORT)}, whose starts are all followed equally long"
        raise place.error(EFFORT, what, "a longer integrate.duration, or no effort")
    states = ", ".join(model.state_names)
    if not config.ensemble.box:
        raise place.error(BOX, "is empty", f"give an interval [low, high] of one or more of {states}")
    for name, (low, high) in config.ensemble.box.items():
        keys = (*BOX, name)
        if name not in model.state_names:
            what = f"{model.name} has no such state{nearest(name, model.state_names)}"
            raise place.error(keys, what, f"it has {states}")
        if name in config.axes:  # what a zipped axis varies as well is told there
            varied = place.other(("axes", name), keys)
            raise place.error(keys, f"is drawn here and varied in {varied}", "keep one of the two")
        if not low < high or not np.isfinite(high - low):
            raise place.error(keys, f"[{low:g}, {high:g}] is no interval", "[low, high] with low < high")
