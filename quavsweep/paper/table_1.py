"""Table 1: the number and names of equilibria from the signs of a2^2, a13^2, a14^2, against a general search."""

from __future__ import annotations

from collections import Counter

import numpy as np

from quavsweep.analysis.equilibrium_search import find_equilibria
from quavsweep.analysis.quadrotor.closed_form import closed_form_equilibria, discriminant, pair, sign_condition
from quavsweep.models import load_model
from quavsweep.paper.item import Findings, Item, Table
from quavsweep.paper.row import Computed
from quavsweep.paper.run import Runs

MODEL = load_model("quadrotor_yaw")
SEED, CRAFTS = 1, 120
CLOSE = 1e-8  # distance of a searched equilibrium from one in closed form, against 1 + |u|
KEYS = {"-": "none", "+ - -": "pmm", "+ + -": "ppm", "+ - +": "pmp", "+ + +": "ppp"}
SPEEDS = np.concatenate([np.linspace(0.0, 10.0, 41), np.linspace(10.0, 500.0, 50)])  # rad/s, with Table 2


def random_craft(random: np.random.Generator) -> dict[str, float]:
    """Return parameters over wide ranges, c of both signs; moments of inertia that no rigid body has among them."""
    moments = {name: random.uniform(3e-3, 1.2e-2) for name in ("Ix", "Iy", "Iz")}
    drags = {name: 10.0 ** random.uniform(-5.0, -2.0) for name in ("k4", "k5", "k6")}
    speeds = {
        "Omega1": 10.0 ** random.uniform(0.0, 2.7),
        "c": random.choice((-1.0, 1.0)) * 10.0 ** random.uniform(-1.0, 1.5),
    }
    return {**MODEL.defaults, **moments, **drags, **speeds, "Ir": 10.0 ** random.uniform(-5.0, -2.0)}


def agrees(craft: dict[str, float]) -> bool:
    """Whether the general search, proved complete, finds the equilibria of Table 1's row and no others."""
    found = find_equilibria(MODEL, craft)
    _, names = sign_condition(craft)
    states = closed_form_equilibria(craft)
    apart = [np.linalg.norm(found.states - states[name], axis=1).min(initial=np.inf) for name in names]
    near = all(d <= CLOSE * (1.0 + np.linalg.norm(states[name])) for d, name in zip(apart, names, strict=True))
    return found.complete and len(found) == len(names) and near


def _analyse(runs: Runs) -> Findings:
    random = np.random.default_rng(SEED)
    crafts = [random_craft(random) for _ in range(CRAFTS)]
    seen, right, names = Counter[str](), Counter[str](), {}
    for craft in crafts:
        signs, names_there = sign_condition(craft)
        seen[signs] += 1
        right[signs] += agrees(craft)
        names[signs] = ", ".join(names_there)
    computed = {
        f"row.{key}": Computed(names[signs] if right[signs] == seen[signs] else "another", note=f"{seen[signs]} crafts")
        for signs, key in KEYS.items()
        if seen[signs]
    }
    rows = {sign_condition({**MODEL.defaults, "Omega1": speed})[0] for speed in SPEEDS}
    computed["five"] = Computed("occurs" if "+ + +" in rows else "does not occur")
    computed["side.names"] = Computed(", ".join(sign_condition(MODEL.defaults)[1][1:]))
    computed["a5.factor"] = Computed(_factor_of_a5(MODEL.defaults))
    table = Table(
        "Rows of Table 1 among random crafts, and in how many the search found just these equilibria",
        ("signs of a2^2, a13^2, a14^2", "equilibria", "crafts", "confirmed"),
        [(signs, names.get(signs, ""), str(seen[signs]), str(right[signs])) for signs in KEYS],
    )
    text = (
        "In equations (18), as the paper's extracted text has them, a5 lacks a factor of 2: with it they give Table 3 "
        "and the pitchfork at c = 5, without it neither; the digit may have been lost in the extraction. "
        "Where Iz lies between Ix and Iy, as in Table 2, the two values of "
        "r have different signs and a13^2, a14^2 are never both positive: r of one pair needs k6 r > T, that of the "
        "other k6 r < T. Five equilibria need an Iz that is the least or the largest, and little drag."
    )
    return Findings(computed, tables=[table], text=text)


def _factor_of_a5(k: dict[str, float]) -> float:
    """Return by what (Ix - Iy) (Ir c)^2 k6 is to be multiplied so that a14^2 of equations (18) is q^2 of E4."""
    roll, yaw, spin = k["Ix"] - k["Iy"], k["Iy"] - k["Iz"], k["Ir"] * k["c"]
    a2 = float(np.sqrt(discriminant(k)))
    torque = 2.0 * k["d"] * (k["c"] ** 2 + 2.0 * k["c"] * k["Omega1"])
    a6_a7, a9_a10, a8 = roll * yaw * spin * torque, yaw * a2 * torque, 2.0 * a2 * k["k6"] * spin
    a11, a12 = yaw * k["k4"] * k["k5"] * k["k6"], roll * yaw**2 * k["k5"]
    rest = a6_a7 + a8 - a9_a10 + a11 - a12 * float(pair(k, -1).q_squared)
    return rest / (roll * spin**2 * k["k6"])


FIGURE = Item(name="table_1", title="Numbers of equilibria by sign conditions", analyse=_analyse)
