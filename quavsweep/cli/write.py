"""The verbs `init` and `schema`: help with writing configs."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import click

from quavsweep.cli.option import PATH, model_option
from quavsweep.cli.text import say
from quavsweep.errors import ConfigError, DiskError


@click.command()
@click.argument("name", metavar="[MODEL]", required=False)
@click.option("--out", type=PATH, metavar="FILE", help="File to write; default MODEL.yaml; - prints it.")
@model_option
def init(name: str | None, out: Path | None, model: Path | None) -> None:
    """Write a commented config for a MODEL, ready to run.

    \b
    quavsweep init                  the quadrotor's yaw manoeuvre
    quavsweep init lorenz --out my_lorenz.yaml
    quavsweep init --model my_model.py
    """
    from quavsweep.config.model import own_model
    from quavsweep.config.template import make_template
    from quavsweep.models import load_model

    if name and model:
        raise ConfigError(f"{name} is of the catalogue, {model} is not", possible="name one of the two")
    chosen = own_model(model) if model else load_model(name or "quadrotor_yaw")
    path = out or Path(f"{chosen.name}.yaml")
    title = re.sub(r"[^A-Za-z0-9._-]|^[._-]", "_", path.stem).lstrip("_") or chosen.name
    text = make_template(chosen, title if str(path) != "-" else chosen.name)
    if str(path) == "-":
        say(text.rstrip())
        return
    try:
        with path.open("x") as file:
            file.write(text)
    except FileExistsError as error:
        raise ConfigError("exists already", str(path), "name another file with --out") from error
    except OSError as error:
        raise DiskError(f"cannot be written: {error.strerror}", str(path)) from error
    own = f" --model {shlex.quote(str(model))}" if model else ""
    say(f"{path}: run it with quavsweep run {shlex.quote(str(path))}{own}")


@click.command()
def schema() -> None:
    """Print the JSON Schema of configs, for editors.

    \b
    quavsweep schema > quavsweep.schema.json

    and as the first line of a config, for editors that speak YAML's language server:

    \b
    # yaml-language-server: $schema=quavsweep.schema.json
    """
    from quavsweep.config.json_schema import json_schema

    say(json.dumps(json_schema(), indent=2))
