"""F37: a state machine that runs, loses power, damages, deletes, changes, and looks, in any order."""

from __future__ import annotations

import random
import shutil
import signal
import tempfile
import threading
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    rule,
    run_state_machine_as_test,
)

from quavsweep import open_result
from quavsweep.config import Sweep, parse_sweep
from quavsweep.errors import IdentityError, LockedError, QuavsweepError, StoppedError
from quavsweep.progress import Progress
from quavsweep.store import RunFolder
from quavsweep.sweep import run_sweep
from quavsweep.verify import verify_folder
from tests.faults.arena import Arena, kill, sha256
from tests.faults.fault import Case, Fault
from tests.faults.kill import invalid, litter, shard_files
from tests.faults.power import Disk, PowerLossError
from tests.faults.subject import GRID, Subject

STEPS_PER_RUN = {"push": 8, "demand": 20}
SMALL = Subject("small", GRID.replace("num: 64", "num: 18").replace("duration: 50", "duration: 20"), tile_cells=3)
REAL = 5  # one run in so many has real processes
THRESHOLDS = (3, 4)
OTHER = ("dt: 0.02", "dt: 0.01")


def sweep_of(errors: int, text: str = SMALL.text) -> Sweep:
    """Return the small sweep with a threshold."""
    return parse_sweep(f"{text}classify: {{errors: {errors}}}\n")


@cache
def expected(errors: int) -> str:
    """Return the SHA-256 of the result that nobody disturbed."""
    with tempfile.TemporaryDirectory() as folder:
        return sha256(run_sweep(sweep_of(errors), folder, tile_cells=SMALL.tile_cells))


class Machine(RuleBasedStateMachine):
    """A folder, what was done to it, and what is promised after each step."""

    arena: Arena
    number = 0

    @initialize(seed=st.integers(0, 2**32))
    def begin(self, seed: int) -> None:
        """Begin with an empty folder."""
        type(self).number += 1
        self.real = self.number % REAL == 0
        self.rng = random.Random(seed)
        self.place = Path(tempfile.mkdtemp(dir=self.arena.folder))
        self.run = self.place / "run"
        self.errors = THRESHOLDS[0]
        self.known: set[Path] = set()
        self.touched: set[Path] = set()
        self.config_touched = False
        self.good: bytes | None = None  # the result before it was damaged

    def teardown(self) -> None:
        """Complete the run: whatever befell it, it ends with the same bytes."""
        if not hasattr(self, "place"):
            return
        if self.config_touched:
            (self.run / "config.yaml").unlink()
            self.config_touched = False
        self._complete()
        assert not litter(self.run), "litter"
        verdict = verify_folder(self.run)
        assert not verdict.damaged, verdict
        assert not verdict.missing, verdict
        shutil.rmtree(self.place)

    def _complete(self) -> None:
        path = run_sweep(
            sweep_of(self.errors), self.run, tile_cells=SMALL.tile_cells, order_seed=self.rng.getrandbits(32)
        )
        assert sha256(path) == expected(self.errors), "other bytes"
        self._all_is_well()

    def _all_is_well(self) -> None:
        self.known -= self.touched - shard_files(self.run)
        self.touched, self.good = set(), None

    @invariant()
    def every_shard_is_valid_and_none_is_lost(self) -> None:
        """Look at what lies there, but for what this machine damaged."""
        if not hasattr(self, "run"):
            return
        there = shard_files(self.run)
        assert not invalid({path for path in there - self.touched if path.is_file()}), "an invalid shard is visible"
        assert self.known - self.touched <= there, "a shard was lost"
        self.known |= there

    @rule()
    def complete(self) -> None:
        """Run to the end."""
        self._mend()
        self._complete()

    @rule(tiles=st.integers(1, 5))
    def stop(self, tiles: int) -> None:
        """Run, and stop after some tiles."""
        self._mend()
        stop, begun = threading.Event(), list[int]()

        def observe(progress: Progress) -> None:
            begun.append(progress.tiles_done)
            if progress.tiles_done >= begun[0] + tiles:
                stop.set()

        with suppress(StoppedError):
            run_sweep(
                sweep_of(self.errors), self.run, tile_cells=SMALL.tile_cells, observe=observe, stop=stop, workers=1
            )
            self._all_is_well()
        self._forget_repaired()

    def _forget_repaired(self) -> None:
        """A shard that was damaged may have been set aside, and done again under the same name."""
        there = shard_files(self.run)
        self.known -= self.touched - there
        self.touched = {path for path in self.touched & there if invalid({path})}

    @rule(steps=st.integers(0, 120), power=st.booleans())
    def die(self, steps: int, power: bool) -> None:
        """Run, and die at a step; with the power goes all that was not synced."""
        self._mend()
        if self.real:
            self._die_really()
            return
        disk = Disk(steps)
        with suppress(PowerLossError, StoppedError), disk.power():
            run_sweep(sweep_of(self.errors), self.run, tile_cells=SMALL.tile_cells, workers=1)
            self._all_is_well()
        if power and self.run.exists():
            disk.lose(self.run, self.rng)
        self._forget_repaired()

    def _die_really(self) -> None:
        config = self.place / "small.yaml"
        config.write_text(f"{SMALL.text}classify: {{errors: {self.errors}}}\n")
        victim = self.arena.command(SMALL, self.place, ["run", str(config), "--out", str(self.run), "--no-plot"])
        victim.process.join(self.rng.uniform(0.1, 0.8))
        kill(victim)
        assert victim.code in (0, -signal.SIGKILL), victim.out
        if victim.code == 0:
            self._all_is_well()
        self._forget_repaired()

    @rule(where=st.floats(0, 1, exclude_max=True), bit=st.integers(0, 2**30))
    def damage_a_shard(self, where: float, bit: int) -> None:
        """Flip a bit of a shard."""
        files = sorted(shard_files(self.run))
        if files:
            path = files[int(where * len(files))]
            self._flip(path, bit)
            self.touched.add(path)

    @rule(bit=st.integers(0, 2**30))
    def damage_the_result(self, bit: int) -> None:
        """Flip a bit of the result."""
        path = self.run / "result.h5"
        if path.is_file():
            self.good = self.good or path.read_bytes()
            self._flip(path, bit)

    @property
    def result_touched(self) -> bool:
        """Whether there is a result that is damaged."""
        path = self.run / "result.h5"
        return self.good is not None and path.is_file() and path.read_bytes() != self.good

    def _flip(self, path: Path, bit: int) -> None:
        data = bytearray(path.read_bytes())
        data[bit // 8 % len(data)] ^= 1 << bit % 8
        path.write_bytes(data)

    @rule(where=st.floats(0, 1, exclude_max=True))
    def delete_a_file(self, where: float) -> None:
        """Delete anything but the config."""
        files = sorted(path for path in self.run.rglob("*") if path.is_file() and path.name != "config.yaml")
        if files:
            path = files[int(where * len(files))]
            path.unlink()
            self.touched.add(path)
            self.known.discard(path)

    @rule(whole=st.booleans())
    def spoil_the_config(self, whole: bool) -> None:
        """Delete the config of the run, or write nonsense into it."""
        path = self.run / "config.yaml"
        if path.exists():
            path.unlink()
            self.config_touched = not whole
            if not whole:
                path.write_text("nonsense: [")

    @rule()
    def mend_the_config(self) -> None:
        """Delete a spoilt config."""
        self._mend()

    def _mend(self) -> None:
        """A run refuses a spoilt config and says to delete it; what rules are open may not depend on chance."""
        if not self.config_touched:
            return
        if shard_files(self.run):
            self._refused(IdentityError, sweep_of(self.errors))
        (self.run / "config.yaml").unlink()
        self.config_touched = False

    @rule()
    def change_a_threshold(self) -> None:
        """Label otherwise from now on."""
        self.errors = THRESHOLDS[THRESHOLDS.index(self.errors) - 1]

    @rule()
    def run_another_sweep(self) -> None:
        """Another sweep is refused where there are shards, and changes nothing."""
        self._mend()
        if shard_files(self.run):
            self._refused(IdentityError, sweep_of(self.errors, SMALL.text.replace(*OTHER)))

    @rule()
    def run_a_second_driver(self) -> None:
        """A second driver is refused, and changes nothing."""
        if self.run.exists():
            with RunFolder(self.run).lock():
                self._refused(LockedError, sweep_of(self.errors))

    def _refused(self, error: type[QuavsweepError], sweep: Sweep) -> None:
        before = self._contents()
        with suppress(error):
            run_sweep(sweep, self.run, tile_cells=SMALL.tile_cells)
            raise AssertionError(f"no {error.__name__}")
        assert self._contents() == before, "a refused run changed the folder"

    def _contents(self) -> dict[Path, tuple[int, int]]:
        files = (path for path in self.run.rglob("*") if path.is_file() and path.name != "lock")
        return {path: (path.stat().st_size, path.stat().st_mtime_ns) for path in files if "quavsweep-" not in path.name}

    @rule()
    def verify(self) -> None:
        """All damage is found."""
        if self.config_touched or not (self.run / "config.yaml").exists():
            return
        with suppress(IdentityError):
            damaged = bool(verify_folder(self.run).damaged)
            there = invalid({path for path in self.touched & shard_files(self.run) if path.is_file()})
            assert damaged or not (there or self.result_touched), "not found"

    @rule()
    def look(self) -> None:
        """Readers say what is wrong, or show what is right."""
        if not self.run.exists():
            return
        try:
            result = open_result(self.run)
            result["region"], result["final_state"]
        except QuavsweepError:
            return
        assert not self.result_touched, "a damaged result was opened"


def _attack(arena: Arena, cases: int) -> Iterator[Case]:
    """Yield a case for each run of the machine; one that fails is told as hypothesis tells it, and ends them."""
    steps = STEPS_PER_RUN["demand" if cases >= 100 else "push"]
    machine: type[Machine] = type("MachineHere", (Machine,), {"arena": arena, "number": 0})
    told: Any = settings(
        max_examples=cases,
        stateful_step_count=steps,
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
        phases=[Phase.generate],
        print_blob=False,
    )
    note = ""
    try:
        run_state_machine_as_test(machine, settings=told)
    except Exception as error:
        note = f"{type(error).__name__}: {error} {'; '.join(getattr(error, '__notes__', []))}"
    for number in range(machine.number - bool(note)):
        yield Case(True, kinds=("real processes" if (number + 1) % REAL == 0 else "simulated",))
    if note:
        yield Case(False, note, silent="other bytes" in note or "not found" in note)


FAULTS = (Fault("F37", f"a state machine, {STEPS_PER_RUN['demand']} steps (8 on a push)", 10, 200, _attack),)
