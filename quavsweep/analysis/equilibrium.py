"""Equilibria near given states, by Newton's method over many cells at once."""

from __future__ import annotations

import numpy as np

from quavsweep.kernels.program import Program

CONTRACTION = 0.1  # the second Newton step against the first; orbits that pass far from equilibria are told by it
POLISH_STEPS = 6  # Newton doubles the digits
CONVERGED = 1e-12  # last step against 1 + |u*|
ROUNDING = 1e-15  # a step so small against 1 + |u*| changes nothing but rounding


Time = np.ndarray | float | None  # of a forced system, in a shape that broadcasts with the states; else None


def vector_field(
    program: Program, u: np.ndarray, coefficients: np.ndarray, t: Time = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return derivatives and Jacobian matrices of n cells.

    Parameters
    ----------
    u : (n, D) float64
    coefficients : (C, n) float64
    t : (n,) float64 or float, optional
        Time, needed if the system is forced.

    Returns
    -------
    du : (n, D) float64
    jacobian : (n, D, D) float64
    """
    n, dimension = u.shape
    outputs = [*program.rhs, *(entry for row in program.jacobian for entry in row)]
    values = program.evaluate(outputs, program.names(np.ascontiguousarray(u.T), coefficients, t))
    table = np.empty((len(outputs), n))
    for row, value in zip(table, values, strict=True):
        row[...] = value
    jacobian = table[dimension:].reshape(dimension, dimension, n)
    return np.ascontiguousarray(table[:dimension].T), np.ascontiguousarray(jacobian.transpose(2, 0, 1))


def derivatives(program: Program, u: np.ndarray, coefficients: np.ndarray, t: Time = None) -> np.ndarray:
    """Return the derivatives of states in columns.

    Parameters
    ----------
    u : (D, ...) float64
    coefficients : (C, ...) float64, in shapes that broadcast with the states
    t : (...) float64 or float, optional
        Time, needed if the system is forced.

    Returns
    -------
    (D, ...) float64
    """
    table = np.empty_like(u)
    for row, value in zip(table, program.evaluate(program.rhs, program.names(u, coefficients, t)), strict=True):
        row[...] = value
    return table


def solve(table: np.ndarray) -> np.ndarray:
    """Solve n small linear systems by elimination with partial pivoting, elementwise over the cells.

    Own code because `np.linalg.solve` raises for all cells if one matrix is singular; here that cell becomes inf or
    nan and its neighbours do not notice. It is also several times faster for small D.

    Parameters
    ----------
    table : (D, D + 1, n) float64
        Matrices with their right-hand sides in the last column; overwritten.

    Returns
    -------
    (D, n) float64
    """
    size = table.shape[0]
    for k in range(size):
        for i in range(k + 1, size):
            larger = np.abs(table[i, k]) > np.abs(table[k, k])
            upper, lower = table[k, k:], table[i, k:]
            table[k, k:], table[i, k:] = np.where(larger, lower, upper), np.where(larger, upper, lower)
        table[k, k + 1 :] /= table[k, k]
        for i in range(size):
            if i != k:
                table[i, k + 1 :] -= table[i, k] * table[k, k + 1 :]
    return table[:, size]


def norm(x: np.ndarray) -> np.ndarray:
    """Return the Euclidean norm over the last axis, summed in order so that it does not depend on the neighbours."""
    total = np.zeros(x.shape[:-1])
    for i in range(x.shape[-1]):
        total += x[..., i] * x[..., i]
    return np.asarray(np.sqrt(total))


def newton(program: Program, u: np.ndarray, coefficients: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the equilibria that Newton's method reaches at once from the given states of an autonomous system.

    A state counts only if the second step is much smaller than the first: elsewhere Newton wanders, and no
    certificate could hold so far from an equilibrium.

    Parameters
    ----------
    u : (n, D) float64
        Finite states.
    coefficients : (C, n) float64

    Returns
    -------
    found : (n,) bool
    equilibrium : (n, D) float64
        Meaningful where found.
    """
    point = np.array(u.T)
    with np.errstate(all="ignore"):
        first = solve(_system(program, point, coefficients))
        point -= first
        second = solve(_system(program, point, coefficients))
        point -= second
        size = norm(second.T)
        found = (size <= CONTRACTION * norm(first.T)) | (size <= CONVERGED * (1.0 + norm(point.T)))
        open_ = np.flatnonzero(found)
        for _ in range(POLISH_STEPS):
            if not open_.size:
                break
            step = solve(_system(program, point[:, open_], coefficients[:, open_]))
            point[:, open_] -= step
            size = norm(step.T)
            found[open_] = size <= CONVERGED * (1.0 + norm(point[:, open_].T))
            open_ = open_[~(size <= ROUNDING * (1.0 + norm(point[:, open_].T)))]
    return found, np.ascontiguousarray(point.T)


def _system(program: Program, u: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
    """Return Jacobian matrices and derivatives beside them at states in columns, (D, D + 1, n)."""
    dimension, n = u.shape
    outputs = [entry for row, f in zip(program.jacobian, program.rhs, strict=True) for entry in (*row, f)]
    table = np.empty((len(outputs), n))
    for row, value in zip(table, program.evaluate(outputs, program.names(u, coefficients)), strict=True):
        row[...] = value
    return table.reshape(dimension, dimension + 1, n)


def eigensystem(jacobian: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return eigenvalues and eigenvectors of n real matrices.

    Returns
    -------
    values : (n, D) complex128
        Largest real part first, then largest imaginary part.
    vectors : (n, D, D) complex128
        Unit columns in the same order.
    """
    values, vectors = np.linalg.eig(jacobian)
    values, vectors = values.astype(np.complex128), vectors.astype(np.complex128)
    order = np.lexsort((-values.imag, -values.real), axis=-1)
    return np.take_along_axis(values, order, axis=-1), np.take_along_axis(vectors, order[:, None, :], axis=-1)
