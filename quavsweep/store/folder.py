"""The folder of a run: where its files lie, its lock, its config and its record."""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import json
import os
import shutil
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from quavsweep.config.document import MAX_BYTES
from quavsweep.config.model import CONFIG, DESCRIPTION
from quavsweep.errors import ConfigError, DiskError, LockedError
from quavsweep.kernels.description import describe_model
from quavsweep.models import NAMES, Model
from quavsweep.models.user import source_text
from quavsweep.provenance import Identity
from quavsweep.store.ledger import is_known, remember
from quavsweep.store.publish import seal_digest
from quavsweep.whole import TEMPORARY, make_folder, plain_file, publish_bytes, writer_lives

LARGEST_RECORD = 2**24  # bytes
LOCK_SECONDS = 0.3  # a reader that asks who runs holds the lock for an instant


def _acquire(handle: int) -> None:
    """Take the lock; OSError if it stays taken."""
    deadline = time.monotonic() + LOCK_SECONDS
    while True:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return
        except OSError:
            if time.monotonic() > deadline:
                raise
            time.sleep(0.02)


@dataclass(frozen=True)
class RunFolder:
    """The paths of a run.

    Parameters
    ----------
    path : Path
        The folder; it need not exist yet.
    """

    path: Path

    @property
    def config(self) -> Path:
        """The canonical config."""
        return self.path / CONFIG

    @property
    def record(self) -> Path:
        """Versions, machine and times of each start."""
        return self.path / "run.json"

    @property
    def result(self) -> Path:
        """The result."""
        return self.path / "result.h5"

    @property
    def failed(self) -> Path:
        """The folder of the tracebacks of tiles that raised."""
        return self.path / "failed"

    @property
    def free_bytes(self) -> int:
        """Free space on the disk where the folder lies or would lie."""
        path = self.path.absolute()
        while not path.is_dir():
            path = path.parent
        return shutil.disk_usage(path).free

    def must_exist(self) -> None:
        """Refuse a path that is not the folder of a run.

        Raises
        ------
        ConfigError
            If it has no config.
        """
        if not self.config.is_file():
            raise ConfigError("is not the folder of a run", str(self.path), "it has no config.yaml")

    def shards(self, evidence_id: str, toolchain_id: str) -> Path:
        """Return the folder of the shards of one identity; those of a stage lie in a folder of their own in it."""
        return self.path / "shards" / evidence_id / toolchain_id

    def identities(self) -> list[tuple[str, str]]:
        """Return the identities of which shards are present."""
        found = (path for path in self.path.glob("shards/*/*/*") if any(path.glob("tile-*.h5")))
        return sorted({(path.parts[-3], path.parts[-2]) for path in found})

    def present_identity(self, identity: Identity) -> Identity:
        """Return the identity whose shards a reader finds: this one, or else that of the engine that made them."""
        present = self.identities()
        if not present or (identity.evidence, identity.toolchain) in present:
            return identity
        evidence, toolchain = max(present, key=lambda ids: len(list(self.shards(*ids).glob("*/tile-*.h5"))))
        return replace(identity, evidence=evidence, toolchain=toolchain)

    @property
    def holder(self) -> str:
        """Who is writing into the folder, as the lock file tells it; empty if nobody is."""
        with contextlib.suppress(OSError):
            handle = os.open(self.path / "lock", os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
            try:
                fcntl.flock(handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
            except OSError:
                return os.pread(handle, 200, 0).decode("utf-8", "replace").strip() or "somebody"
            finally:
                os.close(handle)
        return ""

    @contextlib.contextmanager
    def lock(self, exclusive: bool = True) -> Iterator[None]:
        """Hold the folder for one run at a time; what a killed run left in the making is removed.

        Without `exclusive` the folder is only made sure to be there: for file systems that have no locks.

        Raises
        ------
        LockedError
            If another run holds it.
        ConfigError
            If the path is not a folder.
        DiskError
            If it cannot be made or written.
        """
        try:
            make_folder(self.path)
            handle = os.open(self.path / "lock", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
        except (FileExistsError, NotADirectoryError) as error:
            raise ConfigError("is not a folder", str(self.path), "choose another --out") from error
        except OSError as error:
            raise DiskError(f"cannot be written: {error.strerror}", str(self.path)) from error
        try:
            if not exclusive:
                yield
                return
            try:
                _acquire(handle)
            except OSError as error:
                holder = os.pread(handle, 200, 0).decode("utf-8", "replace").strip()
                raise LockedError(f"another run holds this folder ({holder})", str(self.path)) from error
            with contextlib.suppress(OSError):
                os.ftruncate(handle, 0)
                os.pwrite(handle, f"process {os.getpid()} on {os.uname().nodename}\n".encode(), 0)
            for pattern in (f"{TEMPORARY}*", f"shards/*/*/*/{TEMPORARY}*"):
                for litter in self.path.glob(pattern):
                    if not writer_lives(litter):
                        with contextlib.suppress(OSError):
                            litter.unlink()
            yield
        finally:
            os.close(handle)

    def write_config(self, text: str) -> None:
        """Publish the canonical config; the folder is one of this installation then."""
        remember(hashlib.sha256(text.encode()).hexdigest())
        publish_bytes(self.config, text.encode())

    @property
    def is_own(self) -> bool:
        """Whether its config was written by this installation."""
        with contextlib.suppress(OSError), self.config.open("rb") as file:
            return is_known(hashlib.sha256(file.read(MAX_BYTES)).hexdigest())
        return False

    def trust(self) -> None:
        """Take its config and result for this installation's own from now on, until they change."""
        with contextlib.suppress(OSError), self.config.open("rb") as file:
            remember(hashlib.sha256(file.read(MAX_BYTES)).hexdigest())
        with contextlib.suppress(OSError), self.result.open("rb") as file:
            remember(seal_digest(file))

    def write_model(self, model: Model) -> None:
        """Publish what there is to know of a user's model: its description, and a copy of its file, never run."""
        if model.name in NAMES:
            return
        publish_bytes(self.path / DESCRIPTION, describe_model(model).encode())
        text = source_text(model)
        if text is not None:
            publish_bytes(self.path / "model.py", text.encode())

    def write_starts(self, starts: list[Any]) -> None:
        """Publish the record of all starts of the run."""
        publish_bytes(self.record, (json.dumps({"starts": starts}, indent=1) + "\n").encode())

    def read_starts(self) -> list[dict[str, Any]]:
        """Return the records of all starts, the last one last; empty if there are none that can be read."""
        with contextlib.suppress(OSError, ValueError, RecursionError, AttributeError):
            with plain_file(self.record) as file:
                starts = json.loads(file.read(LARGEST_RECORD)).get("starts")
            return [start for start in starts if isinstance(start, dict)] if isinstance(starts, list) else []
        return []
