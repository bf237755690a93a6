"""Types of options that several verbs share."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from quavsweep.cli.text import seconds_of
from quavsweep.errors import ConfigError


class PathType(click.Path):
    """A path that is not empty."""

    def __init__(self) -> None:
        super().__init__(path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path."""
        if not str(value).strip() or "\0" in str(value):
            self.fail("is not a path", param, ctx)
        return super().convert(value, param, ctx)


class Seconds(click.ParamType):  # type: ignore[type-arg]
    """A time such as 3h50m."""

    name = "time"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the seconds."""
        if isinstance(value, float):
            return value
        try:
            return seconds_of(str(value))
        except ConfigError as error:
            self.fail(str(error), param, ctx)


class KeyValue(click.ParamType):  # type: ignore[type-arg]
    """KEY=NUMBER."""

    name = "key=number"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, float]:
        """Return the key and the number."""
        if isinstance(value, tuple):
            return value
        key, equals, number = str(value).partition("=")
        try:
            if not (key.strip() and equals):
                raise ValueError
            return key.strip(), float(number)
        except ValueError:
            self.fail(f"{value!r} is not KEY=NUMBER, e.g. c=5", param, ctx)


class Limits(click.ParamType):  # type: ignore[type-arg]
    """Two numbers, A,B."""

    name = "a,b"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[float, float]:
        """Return both numbers."""
        if isinstance(value, tuple):
            return value
        try:
            low, high = (float(part) for part in str(value).split(","))
        except ValueError:
            self.fail(f"{value!r} is not A,B, two numbers, e.g. -0.02,0.08", param, ctx)
        return low, high


PATH = PathType()
model_option = click.option(
    "--model",
    "model",
    type=PATH,
    metavar="FILE",
    help="The Python file of a model that is not of the catalogue; it is run.",
)
changes_option = click.option(
    "--set",
    "changes",
    multiple=True,
    metavar="KEY=VALUE",
    help="Change a key of the config, e.g. --set axes.c.num=101; KEY= removes it. May be repeated.",
)
