"""What the classification gives for each cell: names, dimensions, units and meanings."""

from __future__ import annotations

from dataclasses import replace

from quavsweep.classify.self_check import missing_sum, missing_zero
from quavsweep.codes import CYCLE_SYMMETRY
from quavsweep.config import Sweep
from quavsweep.measures import REGION_VARIABLE, STATUS_VARIABLE, Variable

_STATE = (
    Variable("settle_time", (), "float64", "time", "last look outside the certified neighbourhood, from t = 0"),
    Variable("time_used", (), "float64", "time", "time integrated, from t = 0"),
    Variable("final_state", ("state",), "float64", "state", "state at the end"),
    Variable("equilibrium", ("state",), "float64", "state", "equilibrium in which the orbit ends"),
    Variable("eigenvalue_re", ("eigenvalue",), "float64", "1/time", "real parts of the eigenvalues there"),
    Variable("eigenvalue_im", ("eigenvalue",), "float64", "1/time", "imaginary parts of the eigenvalues there"),
    Variable("period", (), "float64", "time", "period of the cycle in which the orbit ends"),
    Variable("cycle_hits", (), "int32", "1", "hits of the section per period"),
    Variable("cycle_symmetry", (), "int8", "1", "how the cycle lies to the model's symmetries", CYCLE_SYMMETRY),
    Variable("cycle_point", ("state",), "float64", "state", "a point of the cycle on the section"),
    Variable("multiplier_re", ("eigenvalue",), "float64", "1", "real parts of the cycle's Floquet multipliers"),
    Variable("multiplier_im", ("eigenvalue",), "float64", "1", "imaginary parts of the cycle's Floquet multipliers"),
)
_SUM_ERROR = Variable("sum_error", (), "float64", "1/time", "sum of the averaged exponents less the mean divergence")
_ZERO_ERROR = Variable("zero_error", (), "float64", "1/time", "smallest size of an exponent away from equilibria")
_LYAPUNOV = (
    Variable(
        "lyapunov",
        ("exponent",),
        "float64",
        "1/time",
        "Lyapunov exponents, exact where certified, else after the transient and, where the end is regular, chaos",
    ),
    Variable("lyapunov_raw", ("exponent",), "float64", "1/time", "Lyapunov exponents averaged after the transient"),
    Variable("lyapunov_se", ("exponent",), "float64", "1/time", "standard error of lyapunov, 0 where certified"),
    Variable(
        "growth_departure",
        ("exponent",),
        "float64",
        "1",
        "F, largest departure of the growth of ln from its straight line; an exponent below classify.neutral F / T "
        "over the time T is neutral",
    ),
    Variable("birkhoff_digits", (), "float64", "1", "digits to which weighted averages of the growth agree"),
    Variable("was_chaotic", (), "int8", "1", "whether the orbit was chaotic at some time (1) or not (0)"),
    Variable("chaotic_until", (), "float64", "time", "end of the chaotic phase, from t = 0; NaN if there was none"),
    Variable("lyapunov_chaotic", (), "float64", "1/time", "largest Lyapunov exponent while chaotic"),
    Variable("lyapunov_chaotic_se", (), "float64", "1/time", "standard error of lyapunov_chaotic"),
)


def result_variables(sweep: Sweep) -> tuple[Variable, ...]:
    """Return what `classify` gives for each cell of a sweep."""
    checks = (
        _or_missing(_SUM_ERROR, missing_sum(sweep)),
        _or_missing(_ZERO_ERROR, missing_zero(sweep)),
    )
    lyapunov = (*_LYAPUNOV, *checks) if sweep.measures.lyapunov else ()
    return (REGION_VARIABLE, STATUS_VARIABLE, *lyapunov, *_STATE, *sweep.measures.outputs)


def _or_missing(variable: Variable, reason: str) -> Variable:
    """Return a variable whose meaning says what NaN means."""
    return replace(variable, meaning=f"{variable.meaning}; NaN: not available{', ' if reason else ''}{reason}")
