"""Speeds, as ratios of two things measured side by side; left out of a plain run: `pytest -m benchmark`."""

from __future__ import annotations

import shutil
import statistics
from pathlib import Path

import pytest

from benchmarks import kernel

pytestmark = pytest.mark.benchmark


def test_the_printed_kernel_keeps_up_with_c(tmp_path: Path) -> None:
    compiler = shutil.which("gcc")
    if compiler is None:
        pytest.skip("gcc is missing")
    contenders = {"printed": kernel.printed(), "C": kernel.handwritten(compiler, tmp_path)}
    samples = kernel.compare(contenders, sample_seconds=0.5)
    assert statistics.median(a / b for a, b in zip(*samples.values(), strict=True)) <= 1.5
