"""What the mutations of configs begin with; the mutants themselves are fault F31."""

from __future__ import annotations

from quavsweep.config import parse_sweep
from tests.broken_config import BASES


def test_the_bases_are_configs() -> None:
    for text in BASES:
        parse_sweep(text, "x.yaml")
