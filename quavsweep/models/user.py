"""A user's model: the file that makes it is run once, and what is wrong with it is told by its line."""

from __future__ import annotations

import hashlib
import importlib.util
import sys
from pathlib import Path

from quavsweep.errors import ModelError
from quavsweep.models import NAMES
from quavsweep.models.mistake import mistake_in
from quavsweep.models.model import Model

_SIZE = 2**20  # bytes
_TEXTS: dict[str, str] = {}  # of the files that were read, by the name of their module


def read_model(path: Path | str) -> Model:
    """Return the MODEL of a Python file.

    The file is run as it is: only files that one would run oneself belong here.

    Raises
    ------
    ModelError
        With file and line, if it cannot be run or makes no model.
    """
    path = Path(path)
    text = _text(path)
    name = f"quavsweep_model_{hashlib.sha256(f'{path.absolute()}{text}'.encode()).hexdigest()[:16]}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None:
        raise ModelError("is no Python file", str(path), "its name ends in .py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name], _TEXTS[name] = module, text  # where the source of its functions is looked for
    try:
        exec(compile(text, str(path), "exec"), module.__dict__)
    except SyntaxError as error:
        raise ModelError(f"cannot be read: {error.msg}", f"{path}:{error.lineno or 1}") from error
    except Exception as error:  # whatever a user's file may raise
        raise mistake_in(error, str(path)) from error
    return _checked(path, module.__dict__.get("MODEL"))


def _text(path: Path) -> str:
    try:
        data = path.read_bytes()
    except OSError as error:
        raise ModelError(f"cannot be read: {error.strerror}", str(path), "--model names a Python file") from error
    if len(data) > _SIZE:
        raise ModelError(f"is larger than {_SIZE} bytes", str(path), "--model names a Python file")
    try:
        return data.decode()
    except UnicodeDecodeError as error:
        raise ModelError("is no text", str(path), "--model names a Python file") from error


def _checked(path: Path, model: object) -> Model:
    if not isinstance(model, Model):
        what = "makes no MODEL" if model is None else f"makes a MODEL that is a {type(model).__name__}"
        raise ModelError(what, str(path), "it must say MODEL = Model(...), with Model from quavsweep.models")
    if model.name in NAMES:
        raise ModelError(f"the catalogue has a model {model.name} already", str(path), "give MODEL another name")
    return model


def source_text(model: Model) -> str | None:
    """Return the text of the file that a model was read from; None if it came by another way."""
    return _TEXTS.get(model.rhs.__module__)
