"""Certificates of sinks: ellipsoids on which a quadratic Lyapunov function provably decreases, for flow and method.

Around an equilibrium u* with Jacobian J, all eigenvalues to the left of zero, x = u - u* is measured by |y|, y = T x.
T^-1 holds the eigenvectors, so that |y| decays at the slowest eigenvalue's rate; where they are nearly parallel, T^T T
solves a Lyapunov equation instead. In these coordinates f(y) = J' y + h(y), and |h(y)| <= beta |y|^2 with beta from the
second derivatives, bounded by interval arithmetic over a box that holds every stage of a step.

- Flow: d|y|/dt <= (mu + beta |y|) |y| with mu the largest eigenvalue of the symmetric part of J'.
- Method: one step maps y to R(dt J') y plus a remainder; |R(dt J')| < 1 is computed, and the remainder is bounded by
  following the bounds of the stages through the table. Both bounds grow with |y|, so if a step shrinks |y| at the
  state's own level, it does so on the whole ellipsoid inside that level, and the orbit can only end in u*.

A tenth of each rate is kept in hand for rounding.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from quavsweep.analysis.equilibrium import eigensystem, newton, norm, vector_field
from quavsweep.analysis.interval import OPERATIONS, Interval, below
from quavsweep.kernels.method import ButcherTable
from quavsweep.kernels.program import Program

IN_HAND = 0.9  # share of a rate that the nonlinear terms may use up
PARALLEL = 1e3  # condition of the eigenvectors beyond which they are not used (they give ellipsoids 6 times larger)
SHIFT = 0.5  # rate that the Lyapunov equation asks for, as a share of the slowest one
FASTEST_ZERO = 1e-10  # a rate below this share of the largest eigenvalue is not told from zero
LOOSE = 1e-6  # width of Gershgorin's discs, as a share of the diagonal, up to which they bound eigenvalues
AT_REST = 1e-9  # distance to an equilibrium, relative to 1 + |u*|, at which a state sits on it


@dataclass(frozen=True)
class Ends:
    """What is known of the ends of n orbits.

    Parameters
    ----------
    inside : (n,) bool
        The state is in the certified neighbourhood of a sink.
    resting : (n,) bool
        The state sits on an equilibrium, whatever its stability.
    equilibrium : (n, D) float64
        NaN where neither holds.
    eigenvalues : (n, D) complex128
        At the equilibrium, largest real part first; NaN where neither holds.
    """

    inside: np.ndarray
    resting: np.ndarray
    equilibrium: np.ndarray
    eigenvalues: np.ndarray


def examine(program: Program, method: ButcherTable, dt: float, u: np.ndarray, coefficients: np.ndarray) -> Ends:
    """Say which states are bound to end in an equilibrium; of forced systems nothing is known.

    Parameters
    ----------
    dt : float
        Step [time unit of the model].
    u : (n, D) float64
        Finite states.
    coefficients : (C, n) float64
    """
    n, dimension = u.shape
    inside = np.zeros(n, dtype=bool)
    resting = np.zeros(n, dtype=bool)
    points = np.full((n, dimension), np.nan)
    values = np.full((n, dimension), complex(np.nan, np.nan))
    if program.forced:
        return Ends(inside, resting, points, values)
    found, equilibrium = newton(program, u, coefficients)
    near = np.flatnonzero(found)
    if near.size:
        u, c, equilibrium = u[near], coefficients[:, near], equilibrium[near]
        jacobian = vector_field(program, equilibrium, c)[1]
        finite = np.isfinite(jacobian).all(axis=(1, 2))
        near, u, c, equilibrium, jacobian = near[finite], u[finite], c[:, finite], equilibrium[finite], jacobian[finite]
        spectrum, vectors = eigensystem(jacobian)
        inside[near] = attracted(program, method, dt, u, c, equilibrium, jacobian, spectrum, vectors)
        resting[near] = norm(u - equilibrium) <= AT_REST * (1.0 + norm(equilibrium))
        known = inside[near] | resting[near]
        points[near[known]] = equilibrium[known]
        values[near[known]] = spectrum[known]
    return Ends(inside, resting, points, values)


def attracted(
    program: Program,
    method: ButcherTable,
    dt: float,
    u: np.ndarray,
    coefficients: np.ndarray,
    equilibrium: np.ndarray,
    jacobian: np.ndarray,
    spectrum: np.ndarray,
    vectors: np.ndarray,
) -> np.ndarray:
    """Return whether each state lies in an ellipsoid around its equilibrium on which |y| provably decreases.

    Parameters
    ----------
    u, equilibrium : (n, D) float64
    coefficients : (C, n) float64
    jacobian : (n, D, D) float64
        At the equilibrium.
    spectrum : (n, D) complex128
        Its eigenvalues, largest real part first.
    vectors : (n, D, D) complex128
        Its eigenvectors, unit columns.

    Returns
    -------
    (n,) bool
    """
    certified = np.zeros(u.shape[0], dtype=bool)
    slowest = spectrum[:, 0].real
    stable = np.flatnonzero(slowest < -FASTEST_ZERO * np.abs(spectrum).max(axis=1))
    if stable.size:
        shape = Shape.around(jacobian[stable], spectrum[stable], vectors[stable])
        level = norm(np.matmul(shape.to_y, (u - equilibrium)[stable, :, None])[:, :, 0])
        certified[stable] = shape.decreases(program, method, dt, equilibrium[stable], coefficients[:, stable], level)
    return certified


@dataclass(frozen=True)
class Shape:
    """The family of ellipsoids |T (u - u*)| <= level around n equilibria.

    Parameters
    ----------
    to_y, to_x : (n, D, D) float64
        T and its inverse.
    linear : (n, D, D) float64
        J' = T J T^-1.
    valid : (n,) bool
        Whether T could be made.
    """

    to_y: np.ndarray
    to_x: np.ndarray
    linear: np.ndarray
    valid: np.ndarray

    @classmethod
    def around(cls, jacobian: np.ndarray, spectrum: np.ndarray, vectors: np.ndarray) -> Shape:
        """Return the shape made of the eigenvectors, or of the Lyapunov equation where they are nearly parallel."""
        imaginary = spectrum.imag[:, None, :]
        columns = np.where(imaginary < 0, vectors.imag, vectors.real) * np.where(imaginary == 0, 1.0, np.sqrt(2.0))
        sizes = np.linalg.svd(columns, compute_uv=False)
        parallel = np.flatnonzero(sizes[:, 0] > PARALLEL * sizes[:, -1])
        columns[parallel] = np.eye(jacobian.shape[-1])
        to_y, to_x, valid = np.linalg.inv(columns), columns, np.ones(len(columns), dtype=bool)
        if parallel.size:
            to_y[parallel], to_x[parallel], valid[parallel] = _lyapunov_shape(
                jacobian[parallel], spectrum[parallel, 0].real
            )
        return cls(to_y, to_x, np.matmul(np.matmul(to_y, jacobian), to_x), valid)

    def decreases(
        self,
        program: Program,
        method: ButcherTable,
        dt: float,
        equilibrium: np.ndarray,
        coefficients: np.ndarray,
        level: np.ndarray,
    ) -> np.ndarray:
        """Return whether flow and method both shrink |y| everywhere on the ellipsoids of these levels, (n,) bool."""
        growth = _largest_eigenvalue(0.5 * (self.linear + self.linear.transpose(0, 2, 1)))
        steepness = _spectral_norm(self.linear)
        contraction = _spectral_norm(_polynomial(method.stability, dt * self.linear))
        with np.errstate(all="ignore"):
            # Twice what the stages of the linear part reach, so that the nonlinear stages stay inside too.
            reach = 2.0 * np.max(_stages(method, dt * steepness, np.zeros_like(level))[0], axis=0) * level
            beta = self._curvature(program, equilibrium, coefficients, reach)
            stages, remainder = _stages(method, dt * steepness, dt * beta * level)
            held = np.max(stages, axis=0) * level <= reach
            flow = beta * level < IN_HAND * -growth
            step = remainder < IN_HAND * (1.0 - contraction)
            return np.asarray(self.valid & held & flow & step)

    def _curvature(
        self, program: Program, equilibrium: np.ndarray, coefficients: np.ndarray, reach: np.ndarray
    ) -> np.ndarray:
        """Return beta with |h(y)| <= beta |y|^2 for all |y| <= reach, (n,) float64.

        h is half the second derivative at a point between, taken twice in y; the Frobenius norm of its centre plus
        that of its radius bounds it. Where the equations compare values, they may have a kink or jump that no second
        derivative tells of, so a box in which a comparison is not certain has no bound.
        """
        n, dimension = equilibrium.shape
        box = reach[:, None] * norm(self.to_x)  # |x_i| <= |row i of T^-1| |y|
        u = [Interval(equilibrium[:, i] - box[:, i], equilibrium[:, i] + box[:, i]) for i in range(dimension)]
        entries = [entry for matrix in program.hessian for row in matrix for entry in row]
        places = [place for place, entry in enumerate(entries) if entry != 0.0]
        names = program.names(u, list(coefficients))
        values = program.evaluate([entries[place] for place in places], names, OPERATIONS)
        centre, radius = np.zeros((2, n, dimension**3))
        for place, value in zip(places, values, strict=True):
            if isinstance(value, Interval):
                centre[:, place], radius[:, place] = value.centre, value.radius
            else:
                centre[:, place] = value
        shape = (n, dimension, dimension, dimension)
        bound = _frobenius(self.to_y, centre.reshape(shape), self.to_x)
        if radius.any():
            bound += _frobenius(np.abs(self.to_y), radius.reshape(shape), np.abs(self.to_x))
        compared = iter(program.evaluate([side for pair in program.switches for side in pair], names, OPERATIONS))
        for left, right in zip(compared, compared, strict=True):
            bound = np.where(np.logical_or(*below(left, right)), bound, np.inf)
        return np.asarray(0.5 * bound)


def _lyapunov_shape(jacobian: np.ndarray, slowest: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return T, T^-1 and validity with T^T T = P, (J + s I)^T P + P (J + s I) = -I; s is part of the slowest rate."""
    n, dimension, _ = jacobian.shape
    one = np.eye(dimension)
    transposed = (jacobian - SHIFT * slowest[:, None, None] * one).transpose(0, 2, 1)
    # vec(A^T P + P A) = (A^T x I + I x A^T) vec(P)
    operator = np.einsum("nac,bd->nabcd", transposed, one) + np.einsum("ac,nbd->nabcd", one, transposed)
    size = dimension * dimension
    right = np.broadcast_to(-one.reshape(size, 1), (n, size, 1))
    form = np.linalg.solve(operator.reshape(n, size, size), right).reshape(n, dimension, dimension)
    squares, vectors = np.linalg.eigh(0.5 * (form + form.transpose(0, 2, 1)))
    valid = np.asarray((squares > 0).all(axis=1))
    roots = np.sqrt(np.where(valid[:, None], squares, 1.0))
    return roots[:, :, None] * vectors.transpose(0, 2, 1), vectors / roots[:, None, :], valid


def _frobenius(to_y: np.ndarray, tensor: np.ndarray, to_x: np.ndarray) -> np.ndarray:
    """Return the Frobenius norm of the quadratic map `tensor` carried into y, (n,)."""
    inner = np.matmul(np.matmul(to_x.transpose(0, 2, 1)[:, None], tensor), to_x[:, None])
    n, dimension = tensor.shape[:2]
    return norm(np.matmul(to_y, inner.reshape(n, dimension, -1)).reshape(n, -1))


def _largest_eigenvalue(symmetric: np.ndarray) -> np.ndarray:
    """Return a bound from above of the largest eigenvalue of n symmetric matrices, by Gershgorin's discs.

    In the coordinates of eigenvectors it is exact. Where the discs are wide, the eigenvalues themselves are computed.
    """
    diagonal = symmetric.diagonal(axis1=1, axis2=2)
    wide = np.abs(symmetric).sum(axis=2) - np.abs(diagonal)
    bound: np.ndarray = (diagonal + wide).max(axis=1)
    loose = np.flatnonzero(wide.max(axis=1) > LOOSE * np.abs(diagonal).min(axis=1))
    if loose.size:
        bound[loose] = np.linalg.eigvalsh(symmetric[loose])[:, -1]
    return bound


def _spectral_norm(matrix: np.ndarray) -> np.ndarray:
    """Return a bound from above of the spectral norm of n matrices: the square root of the eigenvalue of A^T A."""
    squares = _largest_eigenvalue(np.matmul(matrix.transpose(0, 2, 1), matrix))
    return np.asarray(np.sqrt(squares))


def _polynomial(coefficients: tuple[float, ...], matrix: np.ndarray) -> np.ndarray:
    """Return the polynomial of n matrices by Horner's rule; coefficients lowest power first."""
    one = np.eye(matrix.shape[-1])
    value = np.zeros_like(matrix)
    for coefficient in reversed(coefficients):
        value = np.matmul(value, matrix) + coefficient * one
    return value


@cache
def _responses(method: ButcherTable) -> tuple[np.ndarray, np.ndarray]:
    """Return how a step of a linear system answers to its start, and to forces at its stages.

    Returns
    -------
    start : (S + 1, S + 1) float64
        Stage j, and last the end of the step, is sum_i start[j, i] (dt J)^i times the start.
    force : (S + 1, S, S + 1) float64
        A force dt g at stage k moves stage j by sum_i force[j, k, i] (dt J)^i dt g.
    """
    count = method.stages
    start, force = np.zeros((count + 1, count + 1)), np.zeros((count + 1, count, count + 1))
    start[:, 0] = 1.0
    for j, row in enumerate((*method.a, method.b)):
        for k, weight in enumerate(row):
            start[j, 1:] += float(weight) * start[k, :-1]
            force[j, k, 0] += float(weight)
            force[j, :, 1:] += float(weight) * force[k, :, :-1]
    return start, force


def _stages(method: ButcherTable, z: np.ndarray, bend: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Follow one step from |y| = 1 through the method by bounds.

    The force h of the nonlinear part is taken apart, h(y) at the start and what it changes by until a stage, at most
    2 beta times distance times size: weights of large methods are large and of both signs, but act on the first as
    their sum.

    Parameters
    ----------
    z : (n,) float64
        dt times the norm of the linear part.
    bend : (n,) float64
        dt beta times the level, so that dt |h(y)| <= bend in units of the level.

    Returns
    -------
    stages : (S, n) float64
        Bounds of |y| at the stages.
    remainder : (n,) float64
        Bound of the step's departure from its linear part.
    """
    start, force = _responses(method)
    away = _bound(start[:, 1:], z) * z
    together, single = _bound(force.sum(axis=1), z), _bound(force, z)
    changes = np.zeros((method.stages, z.size))
    departures = np.zeros((method.stages + 1, z.size))
    for j in range(method.stages + 1):
        departures[j] = bend * together[j] + (single[j] * changes).sum(axis=0)
        if j < method.stages:
            distance = away[j] + departures[j]
            changes[j] = 2.0 * bend * (1.0 + distance) * distance
    return 1.0 + away[:-1] + departures[:-1], departures[-1]


def _bound(coefficients: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Return the sum over i of |coefficients[..., i]| z^i, of shape (..., n)."""
    value = np.zeros((*coefficients.shape[:-1], z.size))
    for coefficient in np.moveaxis(np.abs(coefficients), -1, 0)[::-1]:
        value = value * z + coefficient[..., None]
    return value
