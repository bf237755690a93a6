"""Peers: what else a user would pick, one file each, imported only when it is measured."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.protocol import Contender, MissingError


@dataclass(frozen=True)
class Peer:
    """A peer that is ready to run.

    Parameters
    ----------
    name : str
        Name of the package.
    exponents : callable
        Integrates all cells over `seconds` of simulated time and returns their exponents, (n, K).
    seconds : float
        Simulated time per call.
    cells : int
        Number of cells.
    """

    name: str
    exponents: Callable[[], np.ndarray]
    seconds: float
    cells: int

    def per_second(self) -> Contender:
        """Return it as a contender that is timed per simulated second and cell."""
        return Contender(self.name, self.exponents, self.seconds * self.cells)


def peer(package: str) -> Any:
    """Import a peer's package.

    Raises
    ------
    MissingError
        If it is not installed, or cannot be loaded.
    """
    try:
        return importlib.import_module(package)
    except ImportError as error:
        raise MissingError(f"{package.partition('.')[0]} is missing: {error}") from error
