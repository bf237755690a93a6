"""The record of a run, `run.json`, with an entry per start, and its log, `log.jsonl`; no result depends on them."""

from __future__ import annotations

import contextlib
import json
import shlex
import sys
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import Any, TextIO

from quavsweep.errors import DiskError, QuavsweepError, StoppedError
from quavsweep.store.folder import RunFolder

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
        What is known at the start: versions, machine, what decides the numbers. `started`, `command`, at the end
        `ended` and `reason` join it; an entry without them is that of a run that was killed.
    """

    folder: RunFolder
    entry: dict[str, Any]
    _starts: list[Any] = field(default_factory=list, init=False)
    _log: TextIO | None = field(default=None, init=False)

    def __enter__(self) -> Journal:
        self._starts = self.folder.read_starts()
        command = shlex.join([Path(sys.argv[0]).name, *sys.argv[1:]])
        self.entry = {"started": now(), "command": command, **self.entry}
        self._write()
        with contextlib.suppress(OSError):
            self._log = (self.folder.path / LOG).open("a", encoding="utf-8")
        self.tell("start", command=command)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.entry |= {"ended": now(), "reason": _reason(error)}
        self.tell("end", reason=self.entry["reason"])
        if self._log is not None:
            with contextlib.suppress(OSError):
                self._log.close()
        with contextlib.suppress(DiskError) if error is not None else contextlib.nullcontext():
            self._write()

    def _write(self) -> None:
        self.folder.write_starts([*self._starts, self.entry])

    def note(self, **values: Any) -> None:
        """Add to the entry of this start; it is written at the end."""
        self.entry |= values

    def tell(self, event: str, **values: Any) -> None:
        """Append a line to the log; where the disk refuses it is lost, which harms nothing."""
        if self._log is not None:
            with contextlib.suppress(OSError):
                self._log.write(json.dumps({"time": now(), "event": event, **values}) + "\n")
                self._log.flush()


def _reason(error: BaseException | None) -> str:
    """Return why a run ended."""
    if error is None:
        return "complete"
    if isinstance(error, StoppedError):
        return f"stopped: {error.what}"
    return str(error) if isinstance(error, QuavsweepError) else f"{type(error).__name__}: {error}"
