"""What can go wrong, each with where it happened, what it is, what is possible instead, and its exit code."""

from __future__ import annotations

import errno

# Of the system's errors those that say nothing about the path that was asked for.
DISK_ERRNOS = frozenset(
    (errno.EIO, errno.EMFILE, errno.ENFILE, errno.ENOMEM, errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.ESTALE)
)
PASSING_ERRNOS = DISK_ERRNOS - {errno.EIO}  # that tell nothing about the bytes of a file
STOPPED = "the run was stopped"


class QuavsweepError(Exception):
    """Base of all errors that a user can meet and mend.

    Parameters
    ----------
    what : str
        What is wrong, in one sentence without a full stop.
    where : str, optional
        File, line and key, or the path concerned.
    possible : str, optional
        What would be accepted, or what to do next.
    """

    exit_code = 1

    def __init__(self, what: str, where: str = "", possible: str = "") -> None:
        self.what, self.where, self.possible = what, where, possible
        super().__init__(what, where, possible)

    def __str__(self) -> str:
        text = f"{self.where}: {self.what}" if self.where else self.what
        return f"{text}; {self.possible}" if self.possible else text


class ConfigError(QuavsweepError):
    """A config or a command that cannot be read or does not make sense."""

    exit_code = 2


class ModelError(QuavsweepError):
    """A model whose equations cannot be turned into a program."""

    exit_code = 2


class TilesFailedError(QuavsweepError):
    """Some tiles raised; everything else was computed."""

    exit_code = 3


class IdentityError(QuavsweepError):
    """A folder holds the evidence of another sweep, engine or toolchain."""

    exit_code = 4


class RefusedError(IdentityError):
    """A worker has another engine, kernel or toolchain than the driver."""


class LockedError(QuavsweepError):
    """Another run is writing into the folder."""

    exit_code = 5


class DamageError(QuavsweepError):
    """Stored bytes are not those that were written."""

    exit_code = 6


class DiskError(QuavsweepError):
    """The disk is full, read-only, or refuses."""

    exit_code = 74


class StoppedError(QuavsweepError):
    """The run was stopped and can be resumed."""

    exit_code = 75
