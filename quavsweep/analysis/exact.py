"""Exponents that certificates give: of sinks from eigenvalues, of cycles from Floquet multipliers."""

from __future__ import annotations

import numpy as np

from quavsweep.codes import Certificate
from quavsweep.measures import Evidence


def exact_exponents(evidence: Evidence) -> np.ndarray:
    """Return all exponents of certified cells, largest first, (n, D) float64 [1/time]; NaN elsewhere.

    Those of a sink are the real parts of its eigenvalues; those of a cycle ln |multiplier| / period, the one in the
    direction of the flow computed like the others.
    """
    certificate = evidence["certificate"][:, None]
    size = np.hypot(evidence["multiplier_re"], evidence["multiplier_im"])
    with np.errstate(divide="ignore", invalid="ignore"):
        cycle = np.log(size) / evidence["period"][:, None]
    exact = np.where(certificate == Certificate.SINK, evidence["eigenvalue_re"], np.nan)
    return np.asarray(np.where(certificate == Certificate.CYCLE, cycle, exact))
