"""Speeds, as ratios of two things measured side by side; left out of a plain run: `pytest -m benchmark`.

The bounds are regressions with room for a busy machine; the targets are those of `python -m benchmarks`.
"""

from __future__ import annotations

import shutil

import pytest

from benchmarks.kernel import kernel_over_c, naive_over_kernel
from benchmarks.protocol import Protocol

pytestmark = pytest.mark.benchmark

BRIEF = Protocol(samples=5, seconds=0.5)


@pytest.mark.parametrize("vectors", [2, 3])
def test_the_printed_kernel_keeps_up_with_c(vectors: int) -> None:
    if shutil.which("gcc") is None:
        pytest.skip("gcc is missing")
    assert kernel_over_c(vectors, BRIEF).value <= 1.4


def test_the_naive_loop_is_far_behind() -> None:
    assert naive_over_kernel(BRIEF).value >= 6.0
