"""What lies on disk: publishing, shards, result files, the folder of a run. The only place that imports h5py.

`quavsweep.store.outcome` is not imported here, because it brings the classification along, which looking does not need.
"""

from quavsweep.store.admission import check_folder
from quavsweep.store.folder import RunFolder
from quavsweep.store.netcdf import Stored, read_result, write_copy
from quavsweep.store.publish import looks_published
from quavsweep.store.shard import Shard, write_shard
from quavsweep.store.shard_set import ShardSet

__all__ = [
    "RunFolder",
    "Shard",
    "ShardSet",
    "Stored",
    "check_folder",
    "looks_published",
    "read_result",
    "write_copy",
    "write_shard",
]
