"""What a worker does with a tile: integrate what is missing of it, publish that, and report a few numbers."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from quavsweep.classify import classify, regions
from quavsweep.codes import REGION
from quavsweep.config import dump_config, parse_sweep
from quavsweep.content import region_counts
from quavsweep.errors import DamageError, RefusedError
from quavsweep.grid import Tile
from quavsweep.integrate import continue_cells, integrate_tile
from quavsweep.kernels.description import describe_model, read_description
from quavsweep.kernels.lookup import keep_program, program_key
from quavsweep.measures import Evidence
from quavsweep.models import NAMES
from quavsweep.passes import with_passes
from quavsweep.plan import Plan, make_plan
from quavsweep.provenance import Identity, identify
from quavsweep.step_check import StepError, check_step, regular_cells
from quavsweep.store import RunFolder, Shard, ShardSet
from quavsweep.store.passes import integrated_passes

Stopped = Callable[[], bool]


@dataclass(frozen=True)
class Done:
    """What a worker reports of a tile.

    Parameters
    ----------
    shards : list of Shard
        Those that it published, or found.
    steps : int
        That it integrated.
    regions : (regions,) int
        Cells per region.
    step_error : StepError or None
        Where the step was checked.
    """

    shards: list[Shard]
    steps: int
    regions: np.ndarray
    step_error: StepError | None


@dataclass
class Worker:
    """Does tiles of a sweep, whatever runs it.

    Parameters
    ----------
    plan : Plan
    shards : ShardSet
        What is there already.
    checked : threading.Event
        Set once the step has been checked, which happens in the first tile with regular cells.
    """

    plan: Plan
    shards: ShardSet
    checked: threading.Event = field(default_factory=threading.Event)

    def __call__(self, tile: Tile, stopped: Stopped) -> Done:
        """Do a tile; `stopped` is asked between calls of the kernel.

        Raises
        ------
        StoppedError
            If `stopped()` became true.
        DiskError
            If a shard cannot be written.
        """
        found, sweep = self._found(tile), self.plan.sweep
        if found is not None and not sweep.keeps_evidence:
            return Done([], 0, region_counts(sweep, found), None)
        evidence, begun, published = self._evidence(tile, found, stopped)
        steps = int(evidence["steps"].sum()) - begun
        count = np.bincount(regions(sweep, evidence), minlength=len(REGION))
        return Done(published, steps, count, self._step_error(tile, evidence, steps, stopped))

    def _found(self, tile: Tile) -> dict[str, np.ndarray] | None:
        """Return the content of the tile's shard, None without a good one."""
        try:
            return self.shards.read(tile.index, {}) if tile.index in self.shards.shards else None
        except DamageError:
            return None  # a later look at all shards sets it aside

    def _evidence(self, tile: Tile, evidence: Evidence | None, stopped: Stopped) -> tuple[Evidence, int, list[Shard]]:
        """Return evidence with all passes of the effort, how many steps of it were there, and new shards."""
        plan, shards = self.plan, self.shards
        published: list[Shard] = []
        begun = 0
        if evidence is not None:
            begun = int(evidence["steps"].sum())
        else:
            begin, earlier = shards.begin(tile.index)
            if earlier is None:
                evidence = integrate_tile(plan, tile, stopped)
            else:
                begun = int(earlier["steps"].sum())
                evidence = continue_cells(plan, earlier, stopped)
            published.append(shards.write(tile, evidence, begin, shards.end))

        def continued(end: int, cells: Evidence) -> Evidence:
            return continue_cells(plan.until(end), cells, stopped)

        go_on = integrated_passes(shards, tile, continued, published)
        return with_passes(plan.sweep, evidence, go_on)[0], begun, published

    def _step_error(self, tile: Tile, evidence: Evidence, steps: int, stopped: Stopped) -> StepError | None:
        """Return the error that the step causes, if nobody has asked for it yet and the tile can tell."""
        plan = self.plan
        if self.checked.is_set():
            return None
        regular = regular_cells(plan.sweep, evidence, classify(plan.sweep, evidence))
        if not regular.any():
            return None
        self.checked.set()
        return check_step(plan, tile, regular, steps / len(tile) * plan.sweep.grid.size, stopped)


@dataclass(frozen=True)
class Order:
    """What a worker in another process needs to know of a sweep; the rest it makes itself, and proves to be the same.

    Parameters
    ----------
    config : str
        The canonical config.
    model : str
        The description of a model that is not of the catalogue, else empty.
    program_key, program : str
        The program of the equations, so that none has to be derived where they are the same, as the key tells.
    folder : Path
        Of the run, on a file system that all share.
    identity : Identity
    tile_cells, lanes : int
    """

    config: str
    model: str
    program_key: str
    program: str
    folder: Path
    identity: Identity
    tile_cells: int
    lanes: int

    @classmethod
    def of(cls, plan: Plan, shards: ShardSet, folder: Path) -> Order:
        """Return the order of a sweep."""
        model = plan.sweep.model
        ours = model.name in NAMES
        return cls(
            dump_config(plan.sweep.canonical()),
            "" if ours else describe_model(model),
            program_key(model) if ours else "",
            plan.program.to_json(),
            folder.absolute(),
            shards.identity,
            shards.tile_cells,
            plan.layout.lanes,
        )


@dataclass(frozen=True)
class Errand:
    """The work of a tile of an order, in any process.

    Parameters
    ----------
    order : Order
    tile : Tile
    check : bool
        Whether the error of the step is asked for.
    known : tuple of str, optional
        Names of the tile's shards; where they are not known the folder is listed, which takes longer the more there
        are.
    """

    order: Order
    tile: Tile
    check: bool
    known: tuple[str, ...] | None = None

    def __call__(self, stopped: Stopped) -> Done:
        """Do it.

        Raises
        ------
        RefusedError
            If this process has another engine, kernel or toolchain, or none.
        StoppedError, DiskError
            As `Worker`.
        """
        order = self.order
        plan = _proven_plan(order)
        folder = RunFolder(order.folder).shards(order.identity.evidence, order.identity.toolchain)
        shards = ShardSet(folder, plan.sweep, order.identity, order.tile_cells)
        shards.find(self.tile.index, self.known)
        checked = threading.Event()
        if not self.check:
            checked.set()
        done = Worker(plan, shards, checked)(self.tile, stopped)
        # Also those that were there: the receipt of a tile may be lost with its worker, and the tile done again.
        return replace(done, shards=[*shards, *done.shards])


_MAKING = threading.Lock()


def _proven_plan(order: Order) -> Plan:
    """Return the plan of an order; what goes wrong before a tile is begun tells of this process alone."""
    try:
        with _MAKING:
            return _plan(order)
    except RefusedError:
        raise
    except Exception as error:
        what = f"a worker cannot make this sweep ({type(error).__name__}: {error})"
        raise RefusedError(what, os.uname().nodename, "mend that installation, or do without it") from error


@lru_cache(maxsize=2)
def _plan(order: Order) -> Plan:
    """Return the plan of an order, after proof that this process makes the same numbers of it as the driver."""
    model = read_description(order.model) if order.model else None
    sweep = parse_sweep(order.config, "the driver's config", model=model)
    if model is None:
        keep_program(sweep.model, order.program_key, order.program)
    here = identify(sweep)
    if (here.evidence, here.toolchain) != (order.identity.evidence, order.identity.toolchain):
        what = "kernel or engine" if here.evidence != order.identity.evidence else "toolchain"
        raise RefusedError(
            f"a worker has another {what} than this process",
            os.uname().nodename,
            "install the same versions of quavsweep, numba, llvmlite and numpy there, on processors alike",
        )
    return make_plan(sweep, order.lanes)
