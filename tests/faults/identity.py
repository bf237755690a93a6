"""What a folder says of itself changes: F13, its config; F27, the engine, toolchain or model that goes on with it."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import quavsweep.provenance
from quavsweep.models import load_model
from quavsweep.provenance import HASHED_MODULES, toolchain
from tests.faults.arena import Arena, Prepare
from tests.faults.fault import Case, Fault
from tests.faults.kill import shard_files
from tests.faults.subject import SMALL


@dataclass(frozen=True)
class Edit:
    """A change of the config in a run's folder, what `run` and `verify` say of it, and a word that is told."""

    name: str
    make: Callable[[Path], object]
    run: int
    verify: int
    says: str = ""


def _replace(name: str, old: str, new: str, run: int = 4, verify: int = 4, says: str = "") -> Edit:
    """Return the edit that puts one text for another."""

    def make(path: Path) -> None:
        text = path.read_text()
        if old not in text:
            raise ValueError(f"{old} is not in {text}")
        path.write_text(text.replace(old, new, 1))

    return Edit(name, make, run, verify, says)


def _cut(path: Path) -> None:
    path.write_text(path.read_text()[:150])


def _folder(path: Path) -> None:
    path.unlink()
    path.mkdir()


def _link(path: Path) -> None:
    path.unlink()
    path.symlink_to("nowhere")


EDITS = (
    _replace("step", "dt: 0.02", "dt: 0.01", says="integrate.dt: 0.01 there, 0.02 here"),
    Edit("deleted", Path.unlink, 0, 2),
    _replace("axis", "stop: 620", "stop: 600", says="axes.rho.stop: 600"),
    Edit("garbage", lambda path: path.write_bytes(b"\xff\x00{["), 4, 2, "cannot be read"),
    _replace("initial state", "x: 1.0", "x: 2.0", says="initial.x: 2.0 there, 1.0 here"),
    _replace("name", "name: quick", "name: slow", run=0, verify=0),
    _replace("comment", "name: quick", "# edited\nname: quick", run=0, verify=0),
    Edit("empty", lambda path: path.write_text(""), 4, 2, "cannot be read"),
    _replace("block", "block: 5", "block: 10", says="measures.lyapunov.block: 10 there, 5 here"),
    Edit("cut", _cut, 4, 2, "cannot be read"),
    _replace("model", "model: lorenz", "model: rossler", verify=2, says="cannot be read"),
    _replace("thresholds", "errors: 3.0", "errors: 4.0", run=0, verify=0),
    # That is also how a folder looks whose run is being extended.
    _replace("duration", "duration: 6.0", "duration: 12.0", verify=0, says="integrate.duration: 12"),
    Edit("a folder in its place", _folder, 4, 2, "cannot be read"),
    Edit("a link to nowhere", _link, 0, 2),
)


def _edited(arena: Arena, cases: int) -> Iterator[Case]:
    for number in range(cases):
        edit = EDITS[number % len(EDITS)]
        with arena.place() as place:
            note = _after_edit(arena, edit, place)
            yield Case(not note, f"{edit.name}: {note}" if note else "", note == "other bytes", (edit.name,))


def _after_edit(arena: Arena, edit: Edit, place: Path) -> str:
    """Return what is wrong with how an edited config is taken."""
    run = place / "run"
    shutil.copytree(arena.undisturbed(SMALL).run, run)
    text = (run / "config.yaml").read_text()
    edit.make(run / "config.yaml")
    verify = arena.command(SMALL, place, ["verify", str(run)])
    if verify.wait() != edit.verify or "Traceback" in verify.out:
        return f"verify ended with {verify.code}: {verify.out[-300:]}"
    victim = arena.start(SMALL, place)
    if victim.wait() != edit.run or edit.says not in victim.out or "Traceback" in victim.out:
        return f"run ended with {victim.code}: {victim.out[-300:]}"
    if edit.run:
        _remove(run / "config.yaml")
    note = arena.finish(SMALL, place)
    return note or ("" if (run / "config.yaml").read_text() == text else "the config was not rebuilt")


def _remove(path: Path) -> None:
    shutil.rmtree(path) if path.is_dir() else path.unlink()


def other_engine(module: str) -> None:
    """Be an engine with another version of a module."""
    provenance = vars(quavsweep.provenance)
    known = provenance["syntax_digest"]
    provenance["syntax_digest"] = lambda code: known(code) + ("'" if code == module else "")


def other_toolchain(key: str) -> None:
    """Have another version of a library, or another processor."""
    toolchain()[key] = "another"


def other_kernel() -> None:
    """Print other kernels."""
    provenance = vars(quavsweep.provenance)
    known = provenance["print_kernel"]
    provenance["print_kernel"] = lambda *arguments: known(*arguments) + "# another\n"


def other_model() -> None:
    """Have another model of that name."""
    object.__setattr__(load_model("lorenz"), "bound", 2e6)


def _changed(arena: Arena, cases: int) -> Iterator[Case]:
    for number in range(cases):
        module, key = arena.rng.choice(HASHED_MODULES), arena.rng.choice(sorted(toolchain()))
        ways: Sequence[tuple[str, Prepare, str]] = (
            ("engine", partial(other_engine, module), f"engine.{module}"),
            ("toolchain", partial(other_toolchain, key), f"{key}: "),
            ("kernel", other_kernel, "kernel: "),
            ("model", other_model, "model.bound: 100000.0 there, 2000000.0 here"),
        )
        name, prepare, says = ways[number % len(ways)]
        with arena.place() as place:
            note = _resumed(arena, prepare, says, place, accept=name == "toolchain")
            yield Case(not note, f"{name}: {note}" if note else "", note == "other bytes", (name,))


def _resumed(arena: Arena, prepare: Prepare, says: str, place: Path, accept: bool) -> str:
    """Return what is wrong with how a run goes on that is half done, by others and then by its own."""
    run = place / "run"
    shutil.copytree(arena.undisturbed(SMALL).run, run)
    (run / "result.h5").unlink()
    files = sorted(shard_files(run))
    for path in arena.rng.sample(files, len(files) // 2):
        path.unlink()
    left = shard_files(run)
    victim = arena.start(SMALL, place, prepare=prepare)
    if victim.wait() != 4 or says not in victim.out or "Traceback" in victim.out:
        return f"exit {victim.code}: {victim.out[-300:]}"
    if shard_files(run) != left or (run / "result.h5").exists():
        return "it was refused, and wrote all the same"
    if accept:
        victim = arena.start(SMALL, place, ("--accept-toolchain",), prepare=prepare)
        if victim.wait() != 0 or "--accept-toolchain" in victim.out:
            return f"--accept-toolchain ended with {victim.code}: {victim.out[-300:]}"
    return arena.finish(SMALL, place)


FAULTS = (
    Fault("F13", "config.yaml of the run edited, damaged or deleted", 10, 60, _edited),
    Fault("F27", "resumed under another engine, toolchain or model", 6, 40, _changed),
)
