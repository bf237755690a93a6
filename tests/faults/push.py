"""The few cases of each fault that every run of the tests makes, in two halves that are run at the same time."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from tests.faults.__main__ import run
from tests.faults.catalogue import FAULTS
from tests.faults.fault import Fault
from tests.faults.record import told

# F01 to F05 are kills, errors and full disks, F14 to F23 other drivers, clusters and stops; the others damage files.
RUNS = [fault for fault in FAULTS if fault.push and (fault.key < "F08" or "F14" <= fault.key < "F25")]
FILES = [fault for fault in FAULTS if fault.push and fault not in RUNS]


def hold(fault: Fault, folder: Path) -> None:
    """Make a few cases and fail unless the promises held; skip if what they need is not to be had."""
    seed = time.time_ns() // 10**6
    tally = run(fault, folder, fault.push, seed)
    print(f"seed {seed}", told(tally), sep="\n")
    assert tally.survived == tally.cases
    if tally.not_run:
        pytest.skip(tally.not_run)
    assert tally.holds
