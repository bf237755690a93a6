"""F08, F09, F10: shards and results whose bytes are not those that were written, met by every reader."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np

from quavsweep import open_result
from quavsweep.codes import Region, Status
from quavsweep.errors import DamageError, DiskError
from quavsweep.plot import draw
from quavsweep.store import read_result
from quavsweep.sweep import run_sweep
from quavsweep.verify import verify_folder
from tests.faults.arena import Arena, Undisturbed, sha256
from tests.faults.fault import Case, Fault
from tests.faults.kill import shard_files
from tests.faults.subject import Subject

AT_ONCE = 10  # damaged shards per repair, at most half of a run's
DETECTED = (DamageError, DiskError)


def _flip(path: Path, arena: Arena) -> None:
    data = bytearray(path.read_bytes())
    bit = arena.rng.randrange(8 * len(data))
    data[bit // 8] ^= 1 << bit % 8
    path.write_bytes(data)


def _truncate(path: Path, arena: Arena) -> None:
    path.write_bytes(path.read_bytes()[: arena.rng.randrange(path.stat().st_size)])


def _zero(path: Path, arena: Arena) -> None:
    data = bytearray(path.read_bytes())
    first = arena.rng.randrange(len(data) - 8)
    last = arena.rng.randint(first + 8, len(data))
    if any(data[first:last]):
        data[first:last] = bytes(last - first)
    else:
        data[:8] = bytes(8)
    path.write_bytes(data)


def _swap(path: Path, arena: Arena) -> None:
    others = sorted(other for other in shard_files(_run_of(path)) - {path} if other.is_file())
    path.write_bytes(arena.rng.choice(others).read_bytes())


def _misname(path: Path, arena: Arena) -> None:
    """Give a file the bytes, the size and the digest of another tile's shard."""
    others = [other for other in path.parent.glob("tile-*.h5") if other != path and other.is_file()]
    if not others:
        return _swap(path, arena)
    other = arena.rng.choice(sorted(others))
    number = path.name.partition(".")[0]
    path.unlink()
    shutil.copyfile(other, path.with_name(number + "." + other.name.partition(".")[2]))
    return None


def _empty(path: Path, arena: Arena) -> None:
    path.write_bytes(b"")


def _make_folder(path: Path, arena: Arena) -> None:
    path.unlink()
    path.mkdir()


def _run_of(path: Path) -> Path:
    return path.parents[4]


EDITS = (_truncate, _zero, _swap, _misname, _empty, _make_folder)
Edit = Callable[[Path, Arena], None]


def _attack(edits: tuple[Edit, ...]) -> Callable[[Arena, int], Iterator[Case]]:
    """Return an attack that edits shards and lets readers, and then a run, find it."""

    def attack(arena: Arena, cases: int) -> Iterator[Case]:
        done = 0
        for subject in arena.subjects():
            for case in _edited(arena, subject, edits, min(AT_ONCE, cases - done)):
                yield case
                done += 1
            if done >= cases:
                return

    return attack


def _edited(arena: Arena, subject: Subject, edits: tuple[Edit, ...], number: int) -> Iterator[Case]:
    """Damage some shards one after the other, each looked at by a reader, then all repaired by a run."""
    whole = arena.undisturbed(subject)
    with arena.place() as place:
        run = place / "run"
        shutil.copytree(whole.run, run)
        (run / "result.h5").unlink()
        files = sorted(shard_files(run))
        damaged = arena.rng.sample(files, min(number, len(files)))
        readers = arena.rng.choices(tuple(READERS), weights=WEIGHTS, k=len(damaged))
        kinds = [arena.rng.choice(edits) for _ in damaged]
        for path, reader, edit in zip(damaged, readers, kinds, strict=True):
            with _aside(path):
                edit(path, arena)
                note = READERS[reader](run, whole)
                shape = edit.__name__.strip("_")
                yield Case(not note, note and f"{reader}, {shape}: {note}", bool(note), (reader, shape))
        for path, edit in zip(damaged, kinds, strict=True):
            edit(path, arena)
        kept = {path: path.stat().st_mtime_ns for path in files if path not in damaged}
        note = _repaired(subject, run, whole, kept)
        if note:
            yield Case(False, note, "other bytes" in note, ("repair",))


@contextmanager
def _aside(path: Path) -> Iterator[None]:
    """Put a shard back afterwards."""
    data, copies = path.read_bytes(), set(path.parent.iterdir())
    try:
        yield
    finally:
        for new in (set(path.parent.iterdir()) - copies) | {path}:
            shutil.rmtree(new) if new.is_dir() else new.unlink(missing_ok=True)
        path.write_bytes(data)


def _repaired(subject: Subject, run: Path, whole: Undisturbed, kept: dict[Path, int]) -> str:
    """Run what is left; return what is wrong with the end."""
    run_sweep(subject.sweep, run, tile_cells=subject.tile_cells)
    if sha256(run / "result.h5") != whole.digest:
        return "other bytes"
    again = [path.name for path, time in kept.items() if not path.is_file() or path.stat().st_mtime_ns != time]
    return f"tiles that were whole were done again: {again}" if again else ""


def _open(run: Path, whole: Undisturbed) -> str:
    """Open an unfinished run; it is honest to say that something is damaged, or that cells are not known."""
    try:
        result = open_result(run)
        values = {name: result[name] for name in READ}
    except DETECTED:
        return ""
    stored = read_result(whole.run / "result.h5").data
    known = (values["status"] != Status.NOT_COMPUTED) & (values["region"] != Region.UNDECIDED)
    same = [_alike(values[name], stored[name], known.shape) for name in READ]
    return "" if (np.all(same, axis=0) | ~known).all() and not np.all(same) else "wrong numbers were read"


def _alike(one: np.ndarray, other: np.ndarray, cells: tuple[int, ...]) -> np.ndarray:
    """Whether cells have the same values, NaN or not."""
    equal = (one == other) | (np.isnan(one) & np.isnan(other))
    return np.asarray(equal.reshape(*cells, -1).all(axis=-1))


def _verify(run: Path, whole: Undisturbed) -> str:
    return "" if verify_folder(run).damaged else "verify found nothing"


def _plot(run: Path, whole: Undisturbed) -> str:
    """Draw an unfinished run; what is not known is left white."""
    with suppress(*DETECTED):
        draw(open_result(run), run / "map.png")
        return _open(run, whole)
    return ""


READ = ("region", "status", "time_used", "lyapunov", "final_state")
READERS = {"open": _open, "verify": _verify, "plot": _plot}
WEIGHTS = (12, 7, 1)
ENDINGS = ("open", "verify", "run")


def _attack_result(arena: Arena, cases: int) -> Iterator[Case]:
    """Flip a bit of a result; readers refuse it, and a run makes it anew."""
    for number, subject in zip(range(cases), arena.subjects(), strict=False):
        whole, ending = arena.undisturbed(subject), ENDINGS[number % len(ENDINGS)]
        with arena.place() as place:
            run = place / "run"
            shutil.copytree(whole.run, run)
            _flip(run / "result.h5", arena)
            note = _met(ending, subject, run, whole)
            yield Case(not note, note and f"{ending}: {note}", bool(note), (ending,))


def _met(ending: str, subject: Subject, run: Path, whole: Undisturbed) -> str:
    """Return what is wrong with how a damaged result is met."""
    if ending == "verify":
        return _verify(run, whole)
    if ending == "run":
        return _repaired(subject, run, whole, {path: path.stat().st_mtime_ns for path in shard_files(run)})
    try:
        result = open_result(run)
    except DETECTED:
        return ""
    return "it was opened" if result.variables else ""


FAULTS = (
    Fault("F08", "a bit flipped in a shard", 500, 10_000, _attack((_flip,))),
    Fault("F09", "a shard cut, zeroed, empty, another's, a folder", 200, 2000, _attack(EDITS)),
    Fault("F10", "a bit flipped in a result", 40, 100, _attack_result),
)
