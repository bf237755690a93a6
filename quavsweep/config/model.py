"""Models that are not of the catalogue: a user's own, or the description that a run's folder keeps."""

from __future__ import annotations

from pathlib import Path

from quavsweep.errors import ConfigError, DamageError, ModelError
from quavsweep.kernels.description import LARGEST, describe_model, read_description
from quavsweep.models import NAMES, Model, load_model
from quavsweep.models.user import read_model

CONFIG, DESCRIPTION = "config.yaml", "model.json"  # names in a run's folder


def own_model(given: Model | Path | str) -> Model:
    """Return a model that is given as such or by its file, once its equations are known to compile.

    Raises
    ------
    ConfigError
        If it has the name of one of the catalogue.
    ModelError
        If it cannot be made or compiled.
    """
    model = given if isinstance(given, Model) else read_model(given)
    if model.name in NAMES:
        if model is not load_model(model.name):
            raise ConfigError(f"the catalogue has a model {model.name} already", possible="give yours another name")
        return model
    try:
        read_description(describe_model(model))
    except ValueError as error:
        what = f"cannot be kept beside its runs ({error})"
        raise ModelError(
            what, model.name, "numbers are finite, texts have one line of at most 1000 characters"
        ) from error
    return model


def described_beside(config: Path) -> Model | None:
    """Return the model whose description lies beside a run's config; None if there is none.

    Raises
    ------
    DamageError
        If it cannot be read.
    """
    path = config.with_name(DESCRIPTION)
    if config.name != CONFIG or not path.is_file():
        return None
    try:
        with path.open("rb") as file:
            return read_description(file.read(LARGEST + 1))
    except (OSError, ValueError) as error:
        what = f"is not the description of a model ({error})"
        raise DamageError(what, str(path), "run the sweep again with --model FILE") from error
