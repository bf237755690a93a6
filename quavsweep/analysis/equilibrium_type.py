"""What kind of equilibrium a spectrum makes, in the words of the paper's Table 3."""

from __future__ import annotations

import numpy as np

NEUTRAL = 1e-10  # a real or imaginary part below this share of the largest eigenvalue is not told from zero


def type_name(eigenvalues: np.ndarray) -> str:
    """Return the type of an equilibrium.

    Nodes have real eigenvalues, foci complex pairs, node-foci both. The index of a saddle is the number of unstable
    directions; a saddle-focus has a complex pair. An equilibrium with an eigenvalue on the imaginary axis is
    `non-hyperbolic`: its linear part does not say what orbits do.

    Parameters
    ----------
    eigenvalues : (D,) complex128 [1/time]
    """
    scale = NEUTRAL * float(np.abs(eigenvalues).max())
    if (np.abs(eigenvalues.real) <= scale).any():
        return "non-hyperbolic"
    unstable = int((eigenvalues.real > 0).sum())
    turning = np.abs(eigenvalues.imag) > scale
    if 0 < unstable < len(eigenvalues):
        return f"{'saddle-focus' if turning.any() else 'saddle'} index {unstable}"
    shape = "focus" if turning.all() else "node-focus" if turning.any() else "node"
    return f"{'unstable' if unstable else 'stable'} {shape}"
