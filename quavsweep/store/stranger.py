"""What lies among a run's shards and is none of its own: told, and never read."""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path

from quavsweep.store.folder import RunFolder
from quavsweep.store.shard import is_shard_name
from quavsweep.whole import TEMPORARY


def strangers(run: RunFolder, evidence_id: str, toolchain_id: str) -> list[str]:
    """Return a sentence for each folder with shards of another identity, and with files that are no shards.

    Parameters
    ----------
    run : RunFolder
    evidence_id, toolchain_id : str
        Of the run's own shards.
    """
    own = run.shards(evidence_id, toolchain_id)
    foreign, odd = Counter[Path](), Counter[Path]()
    for root, _, names in os.walk(run.path / "shards"):
        stage = Path(root)
        shards = sum(map(is_shard_name, names)) if len(stage.parts) == len(own.parts) + 1 else 0
        odd[stage] += sum(not name.startswith(TEMPORARY) for name in names) - shards
        foreign[stage.parent] += 0 if stage.parent == own else shards
    return [
        *(
            f"{folder}: ignored {n} shards of another sweep, engine or toolchain"
            for folder, n in sorted(foreign.items())
            if n
        ),
        *(
            f"{folder}: ignored {n} files that are no shards or were set aside"
            for folder, n in sorted(odd.items())
            if n
        ),
    ]
