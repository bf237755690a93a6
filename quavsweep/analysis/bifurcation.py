"""Where equilibria change along a parameter: saddle-node, transcritical, pitchfork and Hopf bifurcations.

Branches of equilibria are followed through all that the general search finds at some values of the parameter. A real
eigenvalue passes zero where their product does, a complex pair crosses the axis where the product of all sums of two
eigenvalues is zero and the two are no real ones of opposite sign. With v, w the right and left null vectors there

- saddle-node: w f_mu is not zero, nor w D2f(v, v);
- transcritical: w f_mu is zero, but not w D2f(v, v);
- pitchfork: both are zero, but not w D3f(v, v, v) - 3 w D2f(v, J^-1 D2f(v, v)), as a symmetry makes it;
- degenerate: none of these; in a linear system, say.

References
----------
.. [1] Yu. A. Kuznetsov, Elements of Applied Bifurcation Theory, 3rd ed. (2004), chapters 3, 5, 7 and 10.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import partial

import numpy as np

from quavsweep.analysis.branch import Branches, hopf_test, zero_test
from quavsweep.analysis.continuation import zero_between
from quavsweep.analysis.equilibrium import eigensystem
from quavsweep.analysis.equilibrium_search import all_equilibria, autonomous_program, parameter_values, search_box
from quavsweep.errors import ConfigError
from quavsweep.models import Model, load_model

MESH = 17  # values of the parameter at which all equilibria are searched
VANISHES = 1e-6  # share of its size that a coefficient has where it is zero
SAME = 1e-7  # distance between two places, against the range of the parameter and 1 + |u|


class Kind(StrEnum):
    """What happens to an equilibrium."""

    SADDLE_NODE = "saddle-node"
    TRANSCRITICAL = "transcritical"
    PITCHFORK = "pitchfork"
    HOPF = "hopf"
    DEGENERATE = "degenerate"


@dataclass(frozen=True)
class Bifurcation:
    """A bifurcation of an equilibrium.

    Parameters
    ----------
    kind : Kind
        Also a text, as `pitchfork`.
    value : float
        Of the parameter.
    state : (D,) float64
    eigenvalues : (D,) complex128
        Largest real part first [1/time].
    """

    kind: Kind
    value: float
    state: np.ndarray
    eigenvalues: np.ndarray


def find_bifurcations(
    model: Model | str,
    parameter: str,
    low: float,
    high: float,
    parameters: Mapping[str, float] | None = None,
    box: Mapping[str, tuple[float, float]] | None = None,
) -> list[Bifurcation]:
    """Return the bifurcations of a model's equilibria along a parameter, in its order.

    Parameters
    ----------
    model : Model or str
        A model or the name of one of the catalogue.
    parameter : str
        What is varied, from `low` to `high`.
    parameters : mapping, optional
        What differs from the model's defaults.
    box : mapping, optional
        Where to look for equilibria, as in `find_equilibria`.

    Notes
    -----
    Branches that exist only between two of the values at which equilibria are searched, and belong to no other, are
    not seen.

    Raises
    ------
    ConfigError
        If the model is forced, there is no such parameter, or the range is empty.

    Examples
    --------
    >>> [(b.kind.value, round(b.value, 6)) for b in find_bifurcations("lorenz", "rho", 0.0, 20.0)]
    [('pitchfork', 1.0)]
    """
    model = load_model(model) if isinstance(model, str) else model
    program = autonomous_program(model)
    values = parameter_values(model, {**(parameters or {}), parameter: low})
    if not -np.inf < low < high < np.inf:
        raise ConfigError(f"{parameter} from {low:g} to {high:g} is no range", possible="two ascending numbers")
    limits = search_box(model, box or {})
    mesh = np.linspace(low, high, MESH)
    columns = [mesh if name == parameter else np.full(MESH, values[name]) for name in model.parameter_names]
    found = all_equilibria(model, program, program.coefficient_values(columns), limits)
    branches = Branches(model, program, values, parameter, (low, high), limits)
    seeds = [np.append(u, mu) for mu, equilibria in zip(mesh, found, strict=True) for u in equilibria.states]
    places: list[Bifurcation] = []
    for branch in branches.through(seeds):
        for bifurcation in _on_branch(model, branches, branch):
            if not any(_same(model, bifurcation, other, high - low) for other in places):
                places.append(bifurcation)
    return sorted(places, key=lambda b: (b.value, b.kind, *b.state))


def _same(model: Model, one: Bifurcation, other: Bifurcation, reach: float) -> bool:
    apart = np.linalg.norm(model.difference(one.state[None], other.state[None]))
    near = abs(one.value - other.value) <= SAME * reach and apart <= np.sqrt(SAME) * (1.0 + np.linalg.norm(one.state))
    return one.kind is other.kind and bool(near)


def _on_branch(model: Model, branches: Branches, branch: np.ndarray) -> list[Bifurcation]:
    """Return the bifurcations on a followed branch, points (n, D + 1) in its own units."""
    spectra = [branches.spectrum(x) for x in branch]
    found = []
    for test in (zero_test, hopf_test):
        signs = np.sign([test(spectrum) for spectrum in spectra])
        for k in np.flatnonzero(signs[:-1] * signs[1:] < 0):
            place = zero_between(branches.system, branch[k], branch[k + 1], partial(_tested, branches, test))
            if place is not None:
                found += _described(model, branches, place, test is hopf_test)
        for k in np.flatnonzero(signs == 0):
            if 0 < k < len(branch) - 1:
                found += _described(model, branches, branch[k], test is hopf_test)
    return found


def _tested(branches: Branches, test: Callable[[np.ndarray], float], x: np.ndarray) -> float:
    return test(branches.spectrum(x))


def _described(model: Model, branches: Branches, place: np.ndarray, is_hopf: bool) -> list[Bifurcation]:
    """Return the bifurcation at a place; nothing if two real eigenvalues of opposite sign are all there is."""
    u, value = branches.point(place)
    jacobian = branches.jacobian(place)
    eigenvalues = eigensystem(jacobian[None])[0][0]
    if is_hopf and not crosses(eigenvalues):
        return []
    kind = Kind.HOPF if is_hopf else _kind(branches, place, jacobian)
    return [Bifurcation(kind, value, model.wrap(u[None])[0], eigenvalues)]


def crosses(eigenvalues: np.ndarray) -> bool:
    """Return whether the two eigenvalues whose sum is nearest to zero are a complex pair."""
    i, j = np.triu_indices(len(eigenvalues), 1)
    k = int(np.argmin(np.abs(eigenvalues[i] + eigenvalues[j])))
    return bool(abs(eigenvalues[i[k]].imag) > VANISHES * np.abs(eigenvalues).max())


def _kind(branches: Branches, place: np.ndarray, jacobian: np.ndarray) -> Kind:
    """Return what the passing of a real eigenvalue through zero is."""
    left, sizes, right = np.linalg.svd(jacobian)
    w, v = left[:, -1], right[-1]
    inverse = np.linalg.pinv(jacobian, rcond=VANISHES) if sizes[0] > 0 else np.zeros_like(jacobian)
    drift = branches.parameter_derivative(place)
    second, third = branches.higher_derivatives(place, v)
    bend = np.einsum("ijk,j,k->i", second, v, v)
    largest = float(np.abs(second).max())
    drifts = abs(w @ drift) > VANISHES * (np.linalg.norm(drift) + branches.typical_drift(place, v))
    bends = abs(w @ bend) > VANISHES * largest
    if drifts and bends:
        return Kind.SADDLE_NODE
    if bends:
        return Kind.TRANSCRITICAL
    cubic = w @ third - 3.0 * w @ np.einsum("ijk,j,k->i", second, v, inverse @ bend)
    size = np.linalg.norm(third) + 3.0 * largest * np.linalg.norm(inverse @ bend)
    return Kind.PITCHFORK if not drifts and abs(cubic) > VANISHES * size else Kind.DEGENERATE
