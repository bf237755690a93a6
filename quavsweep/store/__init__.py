"""What lies on disk: publishing, shards, result files, the folder of a run. The only place that imports h5py.

`quavsweep.store.outcome` is not imported here, because it brings the classification along, which looking does not need.
"""

from quavsweep.store.admission import check_folder
from quavsweep.store.census import code_blocks, code_counts
from quavsweep.store.failure import Failures
from quavsweep.store.folder import RunFolder
from quavsweep.store.journal import Journal
from quavsweep.store.netcdf import block_cells, write_copy
from quavsweep.store.publish import looks_published
from quavsweep.store.sealed_file import check_result, read_result
from quavsweep.store.shard import Shard, write_shard
from quavsweep.store.shard_set import ShardSet
from quavsweep.store.stored import Part, Stored, Variables
from quavsweep.store.stranger import strangers
from quavsweep.store.thin import thin

__all__ = [
    "Failures",
    "Journal",
    "Part",
    "RunFolder",
    "Shard",
    "ShardSet",
    "Stored",
    "Variables",
    "block_cells",
    "check_folder",
    "check_result",
    "code_blocks",
    "code_counts",
    "looks_published",
    "read_result",
    "strangers",
    "thin",
    "write_copy",
    "write_shard",
]
