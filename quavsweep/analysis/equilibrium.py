"""Equilibria near given states, by Newton's method over many cells at once."""

from __future__ import annotations

import numpy as np

from quavsweep.kernels.program import Program

CONTRACTION = 0.1  # the second Newton step against the first; orbits that pass far from equilibria are told by it
POLISH_STEPS = 6  # Newton doubles the digits
CONVERGED = 1e-12  # last step against 1 + |u*|


def vector_field(program: Program, u: np.ndarray, coefficients: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return derivatives and Jacobian matrices of n cells.

    Parameters
    ----------
    u : (n, D) float64
    coefficients : (C, n) float64

    Returns
    -------
    du : (n, D) float64
    jacobian : (n, D, D) float64
    """
    n, dimension = u.shape
    outputs = [*program.rhs, *(entry for row in program.jacobian for entry in row)]
    values = program.evaluate(outputs, program.names(np.ascontiguousarray(u.T), coefficients))
    table = np.empty((len(outputs), n))
    for row, value in zip(table, values, strict=True):
        row[...] = value
    jacobian = table[dimension:].reshape(dimension, dimension, n)
    return np.ascontiguousarray(table[:dimension].T), np.ascontiguousarray(jacobian.transpose(2, 0, 1))


def derivatives(program: Program, u: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
    """Return the derivatives of states in columns.

    Parameters
    ----------
    u : (D, ...) float64
    coefficients : (C, ...) float64, in shapes that broadcast with the states

    Returns
    -------
    (D, ...) float64
    """
    table = np.empty_like(u)
    for row, value in zip(table, program.evaluate(program.rhs, program.names(u, coefficients)), strict=True):
        row[...] = value
    return table


def solve(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solve n small linear systems by elimination with partial pivoting, elementwise over the cells.

    Own code because `np.linalg.solve` raises for all cells if one matrix is singular; here that cell becomes inf or
    nan and its neighbours do not notice. It is also several times faster for small D.

    Parameters
    ----------
    matrix : (n, D, D) float64
    right : (n, D) float64

    Returns
    -------
    (n, D) float64
    """
    n, size = right.shape
    table = np.concatenate([matrix, right[:, :, None]], axis=2)
    cells = np.arange(n)
    for k in range(size):
        pivot = k + np.argmax(np.abs(table[:, k:, k]), axis=1)
        row = table[cells, pivot]
        table[cells, pivot] = table[:, k]
        table[:, k] = row / row[:, k, None]
        for i in range(size):
            if i != k:
                table[:, i] -= table[:, i, k, None] * table[:, k]
    return table[:, :, size]


def norm(x: np.ndarray) -> np.ndarray:
    """Return the Euclidean norm over the last axis, summed in order so that it does not depend on the neighbours."""
    total = np.zeros(x.shape[:-1])
    for i in range(x.shape[-1]):
        total += x[..., i] * x[..., i]
    return np.asarray(np.sqrt(total))


def newton(program: Program, u: np.ndarray, coefficients: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the equilibria that Newton's method reaches at once from the given states.

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
    with np.errstate(all="ignore"):
        first = solve(*_system(program, u, coefficients))
        equilibrium = u - first
        second = solve(*_system(program, equilibrium, coefficients))
        equilibrium -= second
        found = (norm(second) <= CONTRACTION * norm(first)) | (norm(second) <= CONVERGED * (1.0 + norm(equilibrium)))
        near = np.flatnonzero(found)
        for _ in range(POLISH_STEPS if near.size else 0):
            step = solve(*_system(program, equilibrium[near], coefficients[:, near]))
            equilibrium[near] -= step
            found[near] = norm(step) <= CONVERGED * (1.0 + norm(equilibrium[near]))
    return found, equilibrium


def _system(program: Program, u: np.ndarray, coefficients: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    du, jacobian = vector_field(program, u, coefficients)
    return jacobian, du


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
