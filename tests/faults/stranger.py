"""F11: shards of another sweep, engine or toolchain, and files of other formats, dropped into a run's folder."""

from __future__ import annotations

import hashlib
import itertools
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from tests.faults.arena import Arena, Prepare, sha256
from tests.faults.fault import Case, Fault
from tests.faults.identity import other_engine, other_toolchain
from tests.faults.kill import shard_files
from tests.faults.subject import SMALL, Subject


@dataclass(frozen=True)
class Origin:
    """Who makes shards: a sweep, and what its process is prepared with."""

    name: str
    subject: Subject
    prepare: Prepare | None = None


ORIGINS = (
    Origin("sweep", SMALL),
    Origin("step", Subject("quick", SMALL.text.replace("dt: 0.02", "dt: 0.01"))),
    Origin("axis", Subject("quick", SMALL.text.replace("stop: 620", "stop: 600"))),
    Origin("engine", SMALL, partial(other_engine, "quavsweep.look")),
    Origin("toolchain", SMALL, partial(other_toolchain, "numpy")),
)


def _beside(host: Path, guest: Path) -> str:
    """Put the guest's shards beside those of the host; return what is to be told."""
    for folder in guest.glob("shards/*/*"):
        shutil.copytree(folder, host / folder.relative_to(guest))
    return "ignored 4 shards of another sweep, engine or toolchain"


def _among(host: Path, guest: Path) -> str:
    """Put the guest's shards among those of the host, as if they were its own."""
    stage = next(host.glob("shards/*/*/*"))
    for path in shard_files(guest):
        shutil.copy(path, stage)
    return "no shards or were set aside"


def _named(name: str, data: bytes) -> Callable[[Path, Path], str]:
    """Return what puts a file among the host's shards."""

    def drop(host: Path, guest: Path) -> str:
        stage = next(host.glob("shards/*/*/*"))
        (stage / name).write_bytes(data)
        return "no shards or were set aside"

    return drop


def _as_shard(data: bytes) -> Callable[[Path, Path], str]:
    """Return what puts a file among the host's shards that has a shard's name, digest and size."""
    name = f"tile-0000000.{SMALL.tile_cells}.{len(data)}.{hashlib.sha256(data).hexdigest()}.h5"
    return _named(name, data)


HDF5 = b"\x89HDF\r\n\x1a\n"
WAYS: dict[str, Callable[[Path, Path], str]] = {
    "beside": _beside,
    "among": _among,
    "older name": _named("tile-3.h5", HDF5),
    "another format": _named("tile-0000000.npz", b"PK\x03\x04"),
    "text named as a shard": _as_shard(b"no shard\n"),
    "broken HDF5 named as a shard": _as_shard(HDF5 + bytes(100)),
    "nothing named as a shard": _as_shard(b""),
}
SET_ASIDE = ("among", "text named as a shard", "broken HDF5 named as a shard", "nothing named as a shard")


def _attack(arena: Arena, cases: int) -> Iterator[Case]:
    pairs = list(itertools.permutations(ORIGINS, 2))
    every = [*itertools.product(pairs, ("beside", "among")), *((arena.rng.choice(pairs), way) for way in WAYS)]
    arena.rng.shuffle(every)
    for (host, guest), way in itertools.islice(itertools.cycle(every), cases):
        with arena.place() as place:
            note = _dropped(arena, host, guest, way, place)
            yield Case(not note, f"{host.name}, {guest.name} {way}: {note}" if note else "", "bytes" in note, (way,))


def _made(arena: Arena, origin: Origin) -> Path:
    """Return a finished run, which is not to be changed."""
    place = arena.folder / f"origin-{origin.name}"
    if not place.exists():
        place.mkdir()
        _run(arena, origin, place)
    return place / "run"


def _run(arena: Arena, origin: Origin, place: Path) -> str:
    """Run an origin's sweep into `place/run` and return what is said."""
    config = place / "quick.yaml"
    config.write_text(origin.subject.text)
    command = ["run", str(config), "--out", str(place / "run"), "--no-plot"]
    victim = arena.command(origin.subject, place, command, prepare=origin.prepare)
    if victim.wait() != 0:
        return f"run ended with {victim.code}: {victim.out[-300:]}"
    return victim.out


def _dropped(arena: Arena, host: Origin, guest: Origin, way: str, place: Path) -> str:
    """Return what is wrong with how shards are taken that were dropped into a folder."""
    run, whole = place / "run", _made(arena, host)
    shutil.copytree(whole, run)
    says = WAYS[way](run, _made(arena, guest))
    if arena.rng.random() < 0.5:
        (run / "result.h5").unlink()
    for verb in ("status", "verify"):
        victim = arena.command(host.subject, place, [verb, str(run)], prepare=host.prepare)
        code = 6 if verb == "verify" and way in SET_ASIDE else 0
        if victim.wait() != code or not (says in victim.out or way in SET_ASIDE):
            return f"{verb} ended with {victim.code}: {victim.out[-400:]}"
    told = _run(arena, host, place)
    if says not in told:
        return told[-400:]
    return "" if sha256(run / "result.h5") == sha256(whole / "result.h5") else "other bytes"


FAULTS = (Fault("F11", "shards of another identity or format dropped in", 10, 94, _attack),)
