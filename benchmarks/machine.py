"""What a measurement depends on: processor, cores, versions, commit."""

from __future__ import annotations

import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from quavsweep import provenance

PEERS = ("heyoka", "jitcode", "pynamicalsys", "dynlib", "scipy")


def describe() -> dict[str, Any]:
    """Return processor, cores and versions; a peer that is missing has the version None."""
    record = provenance.machine()
    record["packages"] |= {name: _version(name) for name in PEERS}
    record["gcc"] = _output("gcc", "-dumpfullversion")
    record["commit"] = commit()
    return record


def commit() -> dict[str, Any]:
    """Return the commit that is measured, and whether files differ from it; None outside of a repository."""
    changes = _output("git", "status", "--porcelain")
    return {"id": _output("git", "rev-parse", "HEAD"), "dirty": None if changes is None else bool(changes)}


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _output(*command: str) -> str | None:
    try:
        done = subprocess.run(command, cwd=Path(__file__).parent, check=True, capture_output=True, text=True)
    except (OSError, subprocess.CalledProcessError):
        return None
    return done.stdout.strip()
