"""Attacks with what is read: damaged, foreign or hostile files and configs, odd models, layouts and terminals."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.faults.catalogue import FAULTS
from tests.faults.fault import Fault
from tests.faults.push import FILES, RUNS, hold


@pytest.mark.parametrize("fault", FILES, ids=lambda fault: fault.key)
def test_promises_hold(fault: Fault, tmp_path: Path) -> None:
    hold(fault, tmp_path)


def test_every_fault_is_made_once() -> None:
    assert sorted(f.key for f in (*RUNS, *FILES)) == [fault.key for fault in FAULTS if fault.push]
