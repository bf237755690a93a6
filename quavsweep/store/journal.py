"""The record of a run, `run.json`, with an entry per start, and its log, `log.jsonl`; no result depends on them."""

from __future__ import annotations

import contextlib
import json
import os
import shlex
import sys
import threading
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import Any, TextIO

from quavsweep.errors import STOPPED, DiskError, QuavsweepError, StoppedError
from quavsweep.store.folder import RunFolder
from quavsweep.whole import is_special
from quavsweep.will import will

LOG = "log.jsonl"


def now() -> str:
    """Return the time as ISO 8601 in UTC."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


@dataclass
class Journal:
    """Keeps what happens from the start of a run to its end; use it as a context.

    Parameters
    ----------
    folder : RunFolder
    entry : dict
        What is known at the start: versions, machine. `started`, `command`, then what decides the numbers, and at the
        end `ended` and `reason` join it; an entry without the last is that of a run that was killed.
    """

    folder: RunFolder
    entry: dict[str, Any]
    _starts: list[Any] = field(default_factory=list, init=False)
    _log: TextIO | None = field(default=None, init=False)
    _begun: bool = field(default=False, init=False)
    _ended: bool = field(default=False, init=False)
    _ending: threading.Lock = field(default_factory=threading.Lock, init=False)
    _will: contextlib.ExitStack = field(default_factory=contextlib.ExitStack, init=False)

    def __enter__(self) -> Journal:
        command = shlex.join([Path(sys.argv[0]).name, *sys.argv[1:]])
        self.entry = {"started": now(), "command": command, **self.entry}
        self._will.enter_context(will(lambda: self._end(StoppedError(STOPPED))))
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with self._will:
            if self._begun or isinstance(error, StoppedError):  # one that was refused is none of the folder's starts
                self._end(error)

    def begin(self, **values: Any) -> None:
        """Write that the run is about to begin, and what else is known by then."""
        self.entry |= values
        self._open()
        self._write(self.entry)

    def _open(self) -> None:
        """Open the log, at the beginning of a line whatever a crash left of the last one."""
        self._begun = True
        self._starts = self.folder.read_starts()
        path = self.folder.path / LOG
        with contextlib.suppress(OSError):
            if not is_special(path):
                self._log = path.open("a", encoding="utf-8")
                if not _ends_line(path):
                    self._log.write("\n")
        self.tell("start", time=self.entry["started"], command=self.entry["command"])

    def _end(self, error: BaseException | None) -> None:
        """Write how the run ended, once, in whatever thread that is known first."""
        with self._ending:
            if self._ended:
                return
            self._ended = True
            if not self._begun:
                self._open()
            entry = {**self.entry, "ended": now(), "reason": _reason(error)}
            self.tell("end", reason=entry["reason"])
            if self._log is not None:
                with contextlib.suppress(OSError):
                    self._log.close()
            with contextlib.suppress(DiskError) if error is not None else contextlib.nullcontext():
                self._write(entry)

    def _write(self, entry: dict[str, Any]) -> None:
        self.folder.write_starts([*self._starts, entry])

    def note(self, **values: Any) -> None:
        """Add to the entry of this start; it is written at the end."""
        self.entry |= values

    def tell(self, event: str, **values: Any) -> None:
        """Append a line to the log; where the disk refuses it is lost, which harms nothing."""
        if self._log is not None:
            with contextlib.suppress(OSError, ValueError):  # closed, where the end was told already
                self._log.write(json.dumps({"time": now(), "event": event, **values}) + "\n")
                self._log.flush()


def _ends_line(path: Path) -> bool:
    """Whether a file is empty or ends with a line."""
    with path.open("rb") as file:
        file.seek(-min(file.seek(0, os.SEEK_END), 1), os.SEEK_END)
        return file.read() in (b"", b"\n")


def _reason(error: BaseException | None) -> str:
    """Return why a run ended."""
    if error is None:
        return "complete"
    if isinstance(error, StoppedError):
        return f"stopped: {error.what}"
    return str(error) if isinstance(error, QuavsweepError) else f"{type(error).__name__}: {error}"
