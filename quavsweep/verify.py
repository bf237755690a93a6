"""Checking all bytes of a run's folder against their digests."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from quavsweep.config import load_sweep
from quavsweep.errors import DamageError
from quavsweep.provenance import identify
from quavsweep.store import RunFolder, ShardSet, check_result, strangers
from quavsweep.store.doubt import doubted


@dataclass(frozen=True)
class Verdict:
    """What a check found: shards looked at, tiles missing, whether there is a result, what is damaged and ignored."""

    shards: int
    missing: int
    result: bool
    damaged: tuple[str, ...]
    ignored: tuple[str, ...]


def verify_folder(path: Path, trust: bool = False) -> Verdict:
    """Check every shard and the result of a run's folder; nothing in it is changed.

    Parameters
    ----------
    path : Path
    trust : bool
        Whether to take the folder for one of this installation from now on: without the limits, and the process of
        its own, that files from elsewhere are read with.

    Raises
    ------
    ConfigError
        If the folder is not that of a run.
    """
    folder = RunFolder(path)
    folder.must_exist()
    if trust:
        folder.trust()
    with doubted(path, not folder.is_own):
        return _verdict(folder)


def _verdict(folder: RunFolder) -> Verdict:
    sweep = load_sweep(folder.config)
    identity = folder.present_identity(identify(sweep))
    shards = ShardSet.scan(folder, sweep, identity)
    damaged = [*shards.truncated(), *shards.damage().values()]
    has_result = folder.result.exists()
    if has_result:
        try:
            stored = check_result(folder.result).file_attributes
            if (stored["evidence_id"], stored["toolchain_id"]) != (identity.evidence, identity.toolchain):
                damaged.append(f"{folder.result}: is the result of another sweep, engine or toolchain")
        except DamageError as error:
            damaged.append(str(error))
    ignored = strangers(folder, identity.evidence, identity.toolchain)
    missing = len(shards.missing()) if shards.shards else -1
    return Verdict(len(shards.shards), missing, has_result, tuple(damaged), tuple(ignored))
