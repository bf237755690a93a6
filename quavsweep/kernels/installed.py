"""Versions of the packages that decide numbers."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version

from quavsweep.errors import DiskError


def installed_version(package: str) -> str:
    """Return the version of a package that quavsweep needs.

    Raises
    ------
    DiskError
        If it cannot be found, which tells of a disk that refuses, because the package itself can be imported.
    """
    try:
        return version(package)
    except PackageNotFoundError as error:
        raise DiskError(
            f"the version of {package} cannot be read", possible="try again, or install it again"
        ) from error
