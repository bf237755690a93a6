"""Curves of bifurcations of equilibria in the plane of two parameters.

Unknowns are the state and both parameters, equations f = 0 and a test function that is zero at the bifurcation. At a
pitchfork these are not independent, but on the states that the symmetry leaves as they are, they are: there the
curve of a pitchfork is followed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from quavsweep.analysis.bifurcation import Bifurcation, Kind, crosses, find_bifurcations
from quavsweep.analysis.branch import hopf_test, zero_test
from quavsweep.analysis.continuation import Window, follow
from quavsweep.analysis.equilibrium import vector_field
from quavsweep.analysis.equilibrium_search import autonomous_program, parameter_values, search_box
from quavsweep.errors import ConfigError
from quavsweep.kernels.program import Program
from quavsweep.models import Model, load_model

Reach = tuple[str, float, float]  # a parameter, from where, to where
LINES = 5  # of each direction, along which bifurcations are looked for
NUDGE = 1e-5  # in units of the curve, by which derivatives are taken
STILL = 1e-6  # component of a state, against 1 + |u|, that counts as zero
NEAR = 1e-3  # distance of a bifurcation from a curve, in units of the plane, at which it is on it


def bifurcation_curve(
    model: Model | str,
    kind: Kind | str,
    across: Reach,
    up: Reach,
    parameters: Mapping[str, float] | None = None,
    box: Mapping[str, tuple[float, float]] | None = None,
) -> list[np.ndarray]:
    """Return the curves of a kind of bifurcation in a rectangle of two parameters.

    Parameters
    ----------
    model : Model or str
        A model or the name of one of the catalogue.
    kind : str
        `pitchfork`, `hopf` or `saddle-node`.
    across, up : (str, float, float)
        A parameter and its range.
    parameters : mapping, optional
        What differs from the model's defaults.
    box : mapping, optional
        Where to look for equilibria, as in `find_equilibria`.

    Returns
    -------
    list of (n, 2) float64
        Points of each curve in order, ending at the borders; curves of symmetric partners are one.

    Notes
    -----
    A curve that none of five lines in each direction crosses is not seen.

    Raises
    ------
    ConfigError
        If there is no such parameter, or the kind's curves cannot be followed.
    """
    model = load_model(model) if isinstance(model, str) else model
    if kind not in (Kind.PITCHFORK, Kind.HOPF, Kind.SADDLE_NODE):
        raise ConfigError(f"curves of {kind} points cannot be followed", possible="pitchfork, hopf or saddle-node")
    program = autonomous_program(model)
    values = parameter_values(model, {**(parameters or {}), across[0]: across[1], up[0]: up[1]})
    curves: list[np.ndarray] = []
    for bifurcation, place in _seeds(model, Kind(kind), across, up, values, box or {}):
        if not any(_passes(curve, place, across, up) for curve in curves):
            plane = _Plane(model, program, values, (across, up), bifurcation, search_box(model, box or {}))
            curves += plane.curves(bifurcation.state, place)
    return curves


def _seeds(
    model: Model,
    kind: Kind,
    across: Reach,
    up: Reach,
    values: Mapping[str, float],
    box: Mapping[str, tuple[float, float]],
) -> list[tuple[Bifurcation, np.ndarray]]:
    """Return bifurcations on some lines through the rectangle, with their places in it."""
    found = []
    for along, fixed, order in ((across, up, 1), (up, across, -1)):
        for value in np.linspace(*fixed[1:], LINES):
            for bifurcation in find_bifurcations(model, *along, {**values, fixed[0]: value}, box):
                if bifurcation.kind is kind:
                    found.append((bifurcation, np.array([bifurcation.value, value])[::order]))
    return found


def _passes(curve: np.ndarray, place: np.ndarray, across: Reach, up: Reach) -> bool:
    """Return whether a place is on a curve, by its distance from the chords."""
    width = np.array([across[2] - across[1], up[2] - up[1]])
    points, at = curve / width, place / width
    start, chord = points[:-1], np.diff(points, axis=0)
    length = np.maximum((chord * chord).sum(axis=1), 1e-300)
    share = np.clip(((at - start) * chord).sum(axis=1) / length, 0.0, 1.0)
    return bool((np.linalg.norm(start + share[:, None] * chord - at, axis=1) <= NEAR).any())


class _Plane:
    """Bifurcations of one kind as curves; x = (moving components of u / scale, both parameters from 0 to 1)."""

    def __init__(
        self,
        model: Model,
        program: Program,
        values: Mapping[str, float],
        reaches: Sequence[Reach],
        bifurcation: Bifurcation,
        box: np.ndarray,
    ) -> None:
        self.model, self.program, self.values, self.reaches = model, program, values, reaches
        self.test = hopf_test if bifurcation.kind is Kind.HOPF else zero_test
        self.moving = np.arange(program.dimension)
        if bifurcation.kind is Kind.PITCHFORK:
            self.moving = _kept(model, bifurcation.state)
        self.scale = np.maximum(1.0, np.abs(bifurcation.state))[self.moving]
        self.window = Window(
            *(
                np.append(side[self.moving] / self.scale, [end, end])
                for side, end in zip(box.T, (0.0, 1.0), strict=True)
            )
        )

    def curves(self, state: np.ndarray, place: np.ndarray) -> list[np.ndarray]:
        """Return the curve through a bifurcation; that of a Hopf bifurcation in pieces on which it is one."""
        at = [(value - low) / (high - low) for value, (_, low, high) in zip(place, self.reaches, strict=True)]
        x = follow(self.system, np.append(state[self.moving] / self.scale, at), self.window)
        points = np.column_stack(
            [low + s * (high - low) for s, (_, low, high) in zip(x[:, -2:].T, self.reaches, strict=True)]
        )
        if self.test is zero_test:
            return [points]
        good = np.array([crosses(spectrum) for spectrum in np.linalg.eigvals(self._fields(x)[1])])
        runs = np.split(np.arange(len(x)), np.flatnonzero(np.diff(good)) + 1)
        return [points[run] for run in runs if good[run[0]] and len(run) > 1]

    def system(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return what is zero on the curve, (m,), and its derivatives, (m, m + 1)."""
        size = len(x)
        nudges = NUDGE * np.concatenate([np.zeros((1, size)), np.eye(size), -np.eye(size)])
        du, jacobian = self._fields(x + nudges)
        tests = np.array([self.test(spectrum) for spectrum in np.linalg.eigvals(jacobian).astype(complex)])
        values = np.column_stack([du[:, self.moving], tests])
        return values[0], (values[1 : size + 1] - values[size + 1 :]).T / (2.0 * NUDGE)

    def _fields(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return derivatives and Jacobian matrices at points (n, m + 1)."""
        u = np.zeros((len(x), self.program.dimension))
        u[:, self.moving] = x[:, :-2] * self.scale
        varied = {name: low + s * (high - low) for s, (name, low, high) in zip(x[:, -2:].T, self.reaches, strict=True)}
        given = {**self.values, **varied}
        columns = [np.broadcast_to(given[name], (len(x),)) for name in self.model.parameter_names]
        return vector_field(self.program, u, self.program.coefficient_values(columns))


def _kept(model: Model, state: np.ndarray) -> np.ndarray:
    """Return the components that a symmetry which leaves the state as it is does not turn round.

    Raises
    ------
    ConfigError
        If there is no such symmetry.
    """
    for signs in model.symmetries:
        turned = np.array(signs) < 0
        if (np.abs(state[turned]) <= STILL * (1.0 + np.linalg.norm(state))).all():
            return np.flatnonzero(~turned)
    what = "curves of pitchforks are followed where a symmetry makes them, and the model declares none"
    raise ConfigError(what, model.name, "symmetries=((-1, 1, ...), ...)")
