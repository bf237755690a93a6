"""Attacks on what is running: kills, errors of the system, full disks, other drivers, clusters, stops."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.faults.fault import Fault
from tests.faults.push import RUNS, hold


@pytest.mark.parametrize("fault", RUNS, ids=lambda fault: fault.key)
def test_promises_hold(fault: Fault, tmp_path: Path) -> None:
    hold(fault, tmp_path)
