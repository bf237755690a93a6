"""Doubt about what comes from elsewhere: its config is parsed as any, and whatever goes wrong with it is damage."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from quavsweep.config import Sweep, dump_config, parse_sweep
from quavsweep.config.document import MAX_BYTES
from quavsweep.errors import DamageError, QuavsweepError
from quavsweep.kernels.description import read_description
from quavsweep.models import Model
from quavsweep.store.outcome import DESCRIPTION

AGAIN = "run the sweep again, or ask whoever sent it"
_ODD = (ArithmeticError, LookupError, ValueError, TypeError, AttributeError, AssertionError, RuntimeError, MemoryError)


class Misfit(ValueError):  # noqa: N818  what it says of a file is no error of this program
    """What does not fit the config of a file."""


@contextlib.contextmanager
def doubted(where: Path, foreign: bool = True) -> Iterator[None]:
    """Tell whatever goes wrong with what comes from elsewhere as damage, not as a mistake of this program."""
    try:
        yield
    except QuavsweepError:
        raise
    except _ODD as error:
        if not foreign:
            raise
        why = str(error) if isinstance(error, Misfit) else type(error).__name__
        raise DamageError(f"makes no sense as a result ({why})", str(where), AGAIN) from error


def sweep_of(attributes: Mapping[str, Any], where: Path) -> Sweep:
    """Return the sweep whose result has these attributes; its name is `result`.

    Raises
    ------
    ConfigError
        If its config makes no sense.
    DamageError
        If there is none, or the description of its model cannot be read.
    """
    try:
        text = attributes["config"]
        settings = json.loads(text) if len(text) <= MAX_BYTES else None
        if not isinstance(settings, dict):
            raise ValueError("it is no mapping")
    except (KeyError, TypeError, ValueError, RecursionError) as error:
        raise DamageError("holds no config", str(where), AGAIN) from error
    with doubted(where):
        return parse_sweep(dump_config({"name": "result", **settings}), str(where), model=_described(attributes, where))


def _described(attributes: Mapping[str, Any], where: Path) -> Model | None:
    """Return the model that a file describes; None if it is one of the catalogue."""
    text = attributes.get(DESCRIPTION)
    if text is None:
        return None
    try:
        return read_description(str(text))
    except ValueError as error:
        raise DamageError(
            f"holds no description of a model ({str(error)[:200]})", str(where), "run the sweep again"
        ) from error
