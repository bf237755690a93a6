"""The configs whose keys are broken, one at a time, and whether a message names the key and its line."""

from __future__ import annotations

import re
from pathlib import Path

from quavsweep.errors import ConfigError
from tests.conftest import LORENZ, YAW
from tests.mutation import Mutant, styles

# Every key that a config can have, in both kinds of axes.
FULL = """
name: full
model: quadrotor_yaw
parameters: {Ix: 4.9e-3, d: 1.1e-6}
initial: {q: 0.001, r: 0.001}
axes:
  Omega1: {start: 50, stop: 500, num: 9, spacing: log}
  c: {values: [3, 4.5, 7]}
  p: {start: -1, stop: 1, num: 3, spacing: linear}
integrate: {method: rk4, dt: 0.02, transient: 200, duration: 600, segment: 20}
measures:
  lyapunov: {exponents: 3, block: 25, batch: 5}
  orbit: {every: 0.5, after: 1, until: 20}
  samples: {section: {of: r, at: 0.5, direction: up}, max: 40}
  peak: {of: [p, q], until: 20}
  first_time: {of: p, above: 1.05, until: 20}
stop_early: true
classify: {errors: 3, neutral: 5}
"""
ZIPPED = """name: curve
model: quadrotor_yaw
initial: {p: 0.001, q: 0.001, r: 0.001}
axes:
  hover:
    zip: {Omega1: [197.4, 196.4, 195.4], c: {start: 3, stop: 7, num: 3}}
  Ix: {values: [3.0e-3, 4.0e-3]}
integrate: {dt: 0.02, transient: 200, duration: 600}
effort: {max_duration: 1200, of: [undecided, chaos]}
"""
CONFIGS = [path.read_text() for path in sorted((Path(__file__).parent.parent / "configs").rglob("*.yaml"))]
BASES = [styled for text in (YAW, LORENZ, FULL, FULL, ZIPPED, *CONFIGS) for styled in styles(text)]
WHERE = re.compile(r".*x\.yaml:(\d+)(?:: (.*))?", re.DOTALL)  # how a message begins


def is_named(broken: Mutant, error: ConfigError) -> bool:
    """Whether a message begins with the line and the key, or a key inside, or speaks of the whole key and its line."""
    match = WHERE.fullmatch(error.where)
    if match is None:
        return False
    line, key = int(match[1]), re.sub(r" \(item \d+\)", "", match[2] or "")
    text, paths = str(error), {".".join(path) for path in broken.paths}
    if line in broken.lines and any(_is_in(key, path) for path in paths):
        return True
    told = line in broken.lines or any(re.search(rf"line {n}\b", text) for n in broken.lines)
    return told and any(re.search(rf"(?<![\w.]){re.escape(path)}(?![\w])", text) for path in paths - {""})


def _is_in(key: str, path: str) -> bool:
    """Whether a named key is the one looked for, one inside it, or has the same last part; "" is the whole text."""
    if not path:
        return not key
    last = path.rpartition(".")[2]
    return f"{key}.".startswith(f"{path}.") or key == last or key.endswith(f".{last}")
