"""Where tiles are run: on threads, or on a cluster; the only place that imports dask."""

from quavsweep.executor.receipt import Executor, Receipt, Task, TaskOf
from quavsweep.executor.threads import Threads

__all__ = ["Executor", "Receipt", "Task", "TaskOf", "Threads"]
