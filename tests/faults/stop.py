"""F23: Ctrl-C once and twice, SIGTERM, SIGHUP, SIGUSR1 and the end of the time, at any moment of a run.

Before the first line of ours runs, a signal does what Python lets it do: SIGTERM kills, Ctrl-C raises. What is resumed
has the same bytes all the same.
"""

from __future__ import annotations

import itertools
import shutil
import signal
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Any

import quavsweep.work
from quavsweep.cli.stop import SIGNALS
from quavsweep.store import RunFolder
from tests.faults.arena import HANG_SECONDS, Arena, Victim
from tests.faults.crew import have_children
from tests.faults.fault import Case, Fault
from tests.faults.interpreter import run_fresh
from tests.faults.probe import Probe
from tests.faults.subject import ENSEMBLE, GRID, SUBJECTS, Subject

SECONDS = 2.0
HELD_SECONDS = 0.1
DONE, STOPPED, TWICE = 0, 75, 130
WAYS = ("Ctrl-C", "Ctrl-C twice", "SIGTERM", "SIGHUP", "SIGUSR1", "--max-time")
NUMBERS = {way: signal.SIGINT if "Ctrl-C" in way else signal.Signals[way] for way in WAYS[:-1]}
HUGE = Subject("huge", GRID.replace("name: grid", "name: huge").replace("num: 64", "num: 512"), 512)
WIDE = Subject("wide", ENSEMBLE.replace("name: ensemble", "name: wide").replace("num: 8", "num: 256"), 256)
GRID_SUBJECT, ENSEMBLE_SUBJECT = SUBJECTS
Start = Callable[[Arena, Subject, Path, tuple[str, ...]], Victim]


def _forked(arena: Arena, subject: Subject, place: Path, arguments: tuple[str, ...], *, held: bool = False) -> Victim:
    victim = arena.start(subject, place, arguments, gated=True, prepare=partial(_prepare, place, held))
    victim.wait_until_stopped()
    victim.begun = time.monotonic()
    victim.send(signal.SIGCONT)
    return victim


def _prepare(place: Path, held: bool) -> None:
    """Tell of more phases than others want to know of, and let signals do what they do in a new interpreter."""
    probe = Probe(place / "probe")
    work = vars(quavsweep.work)
    if held:
        work["check_step"] = probe.around("checking", _held(work["check_step"]))
    work["continue_cells"] = probe.around("going on", work["continue_cells"])
    for number in SIGNALS:
        signal.signal(number, signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL)
    have_children()


def _held(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that waits a while first, because it takes so little time that it could not be hit."""

    def held(*arguments: Any) -> Any:
        time.sleep(HELD_SECONDS)
        return function(*arguments)

    return held


def _processes(arena: Arena, subject: Subject, place: Path, arguments: tuple[str, ...]) -> Victim:
    return _forked(arena, subject, place, ("--processes", "2", *arguments))


@dataclass(frozen=True)
class Scene:
    """Where in a run it is stopped.

    Parameters
    ----------
    name : str
    subject : Subject
    seconds : float
        Within which it is stopped, once it or the phase has begun [s]; 0 for the time of an undisturbed run.
    phase : str
        That of the probe, empty for the whole run.
    rounds : int
        Stops of a run before it may go on to its end.
    start : callable
        Starts the run.
    integrated : bool
        Whether all tiles are there when it starts.
    """

    name: str
    subject: Subject
    seconds: float = 0.0
    phase: str = ""
    rounds: int = 4
    start: Start = _forked
    integrated: bool = False

    @property
    def timed(self) -> bool:
        """Whether it is known from which moment on `--max-time` counts."""
        return not self.phase and self.start in (_forked, _processes)


SCENES = (
    Scene("tiles", GRID_SUBJECT),
    Scene("consolidating", WIDE, 0.3, "consolidating", integrated=True),
    Scene("one tile", HUGE),
    Scene("tiles", ENSEMBLE_SUBJECT),
    Scene("start-up", GRID_SUBJECT, 0.6, start=partial(run_fresh, cold=False)),
    Scene("effort", HUGE, 0.3, "going on"),
    Scene("step check", GRID_SUBJECT, HELD_SECONDS, "checking", start=partial(_forked, held=True)),
    Scene("processes", GRID_SUBJECT, 4.0, rounds=2, start=_processes),
    Scene("compiling", GRID_SUBJECT, 4.0, rounds=1, start=partial(run_fresh, cold=True)),
    Scene("tiles", GRID_SUBJECT),
    Scene("tiles", ENSEMBLE_SUBJECT),
)


def _attack(arena: Arena, cases: int) -> Iterator[Case]:
    done = 0
    for scene in itertools.cycle(SCENES):
        for case in _history(arena, scene):
            yield case
            done += 1
        if done >= cases:
            return


def _history(arena: Arena, scene: Scene) -> Iterator[Case]:
    """Yield a case for each stop of a run; the last of them tells how the run ended."""
    with arena.place() as place:
        whole, last = arena.undisturbed(scene.subject), Case(True)
        if scene.integrated:
            shutil.copytree(whole.run, place / "run", ignore=shutil.ignore_patterns("result.h5"))
        for number in range(scene.rounds):
            if number:
                yield last
            last, done = _stop(arena, scene, place)
            if done:
                break
        note = last.note or arena.finish(scene.subject, place)
        yield replace(last, survived=not note, note=note, silent=note == "other bytes")


def _stop(arena: Arena, scene: Scene, place: Path) -> tuple[Case, bool]:
    """Stop a run in some way; return what became of it, and whether it was done."""
    rng = arena.rng
    way = rng.choice(WAYS if scene.timed else WAYS[:-1])
    delay = rng.uniform(0.001, scene.seconds or arena.undisturbed(scene.subject).seconds)
    victim = scene.start(arena, scene.subject, place, ("--max-time", f"{delay:.3f}s") if way == WAYS[-1] else ())
    if way == WAYS[-1]:
        heard, told = True, victim.begun + delay
    else:
        _wait_for(victim, scene.phase)
        victim.process.join(delay)
        heard, told = _hears(victim), time.monotonic()
        victim.send(NUMBERS[way])
        if "twice" in way:
            victim.process.join(rng.uniform(0.005, 0.2))
            victim.send(signal.SIGINT)
    code = victim.wait()
    note = _wrong(way, heard, code, time.monotonic() - told) or _silence(victim, code)
    note = note and f"{scene.name}: {way} after {told - victim.begun:.2f} s {note}: {victim.out[-300:]}"
    return Case(not note, note, kinds=(scene.name, way, _outcome(heard, code))), code == DONE


def _wait_for(victim: Victim, phase: str) -> None:
    """Wait until a phase of a run has begun, or the run has ended."""
    probe, deadline = Probe(victim.folder / "probe"), time.monotonic() + HANG_SECONDS
    while phase and victim.code is None and not probe[phase] and time.monotonic() < deadline:
        time.sleep(0.001)


def _hears(victim: Victim) -> bool:
    """Whether a process has a handler for SIGTERM, as Python has none."""
    try:
        status = Path(f"/proc/{victim.pid}/status").read_text()
    except OSError:
        return False
    caught = next((line for line in status.splitlines() if line.startswith("SigCgt")), "SigCgt 0")
    return bool(int(caught.split()[1], 16) >> (signal.SIGTERM - 1) & 1)


def _wrong(way: str, heard: bool, code: int | None, seconds: float) -> str:
    """Return what is wrong with an end, empty if nothing is."""
    allowed = {DONE, STOPPED, *([TWICE] if "twice" in way else [])}
    if not heard:
        allowed |= {-NUMBERS[way], *([1, TWICE] if "Ctrl-C" in way else [])}
    if code is None:
        return "was not answered"
    if code not in allowed:
        return f"ended with {code}"
    return f"took {seconds:.2f} s" if seconds > SECONDS else ""


def _silence(victim: Victim, code: int | None) -> str:
    """Return what is wrong with the reason that a run has left of its end, empty if nothing is."""
    began = time.time() - (time.monotonic() - victim.begun)
    starts = RunFolder(victim.folder / "run").read_starts()
    own = [start for start in starts if datetime.fromisoformat(start["started"]).timestamp() >= began - 0.01]
    return "left no reason" if code in (DONE, STOPPED) and own and "reason" not in own[-1] else ""


def _outcome(heard: bool, code: int | None) -> str:
    known = {DONE: "it was done", STOPPED: "exit 75", TWICE: "exit 130"}
    return known.get(code or 0, "other") if heard else "before there are handlers"


def _whole(kinds: Counter[str], cases: int) -> str:
    """Return what is wrong with the ends of all runs together."""
    twice, answered = kinds[WAYS[1]], kinds["exit 130"]  # others had ended, or were about to, before the second
    few = answered < 0.15 * twice if twice >= 20 else twice >= 10 and not answered
    return f"{answered} of {twice} second Ctrl-Cs were answered" if few else ""


FAULTS = (Fault("F23", "Ctrl-C, SIGTERM, SIGHUP, SIGUSR1, --max-time at any time", 40, 400, _attack, _whole),)
