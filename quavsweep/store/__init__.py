"""What lies on disk: publishing, shards, result files, the folder of a run. The only place that imports h5py."""

from quavsweep.store.folder import RunFolder
from quavsweep.store.netcdf import Stored, read_result
from quavsweep.store.outcome import outcome_in_memory, write_outcome
from quavsweep.store.publish import looks_published
from quavsweep.store.shard import write_shard
from quavsweep.store.shard_set import ShardSet

__all__ = [
    "RunFolder",
    "ShardSet",
    "Stored",
    "looks_published",
    "outcome_in_memory",
    "read_result",
    "write_outcome",
    "write_shard",
]
