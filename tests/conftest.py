"""What several tests share: small sweeps, and caches that a test run does not share with the user."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from quavsweep.config import Sweep, parse_sweep

YAW = """
name: small
model: quadrotor_yaw
initial: {p: 0.001, q: 0.001, r: 0.001}
axes:
  Omega1: {start: 50, stop: 500, num: 9}
  c: {start: 3, stop: 7, num: 5}
integrate: {method: rk4, dt: 0.02, transient: 200, duration: 600}
measures: {lyapunov: {exponents: 3, block: 25}}
"""

# At dt = 0.02 RK4 diverges from about rho = 400 on.
LORENZ = """
name: lorenz
model: lorenz
initial: {x: 1.0, y: 1.0, z: 20.0}
axes:
  rho: {start: 0.5, stop: 600, num: 60}
integrate: {method: rk4, dt: 0.02, transient: 20, duration: 80}
measures: {lyapunov: {exponents: 3, block: 5}}
"""


LONGEST = ("test_runs.py", "test_files.py", "test_readme.py")  # files that are begun first where two are run at a time


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the files first that take longest."""
    items.sort(key=lambda item: item.path.name not in LONGEST)


@pytest.fixture(scope="session", autouse=True)
def kernel_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Give the test run a kernel cache of its own, for its processes too."""
    folder = tmp_path_factory.mktemp("cache")
    os.environ["QUAVSWEEP_CACHE"] = str(folder)
    yield folder
    del os.environ["QUAVSWEEP_CACHE"]


@pytest.fixture
def make_sweep() -> Callable[..., Sweep]:
    """Return a function from YAML text, and texts to replace in it, to a sweep."""

    def make(text: str, *changes: tuple[str, str]) -> Sweep:
        for old, new in changes:
            assert old in text, old
            text = text.replace(old, new)
        return parse_sweep(text, "test.yaml")

    return make
