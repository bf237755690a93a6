"""Every number of the paper's text and tables, as data: a YAML file per figure, table or section."""

from __future__ import annotations

from pathlib import Path

from ruamel.yaml import YAML

from quavsweep.errors import ConfigError
from quavsweep.paper.row import Printed

FIELDS = ("key", "where", "what", "paper", "unit", "reason")


def read_printed(name: str) -> tuple[Printed, ...]:
    """Return what the paper prints of an item, in the order of its file; nothing if it has none.

    A file is a list of rows with the fields of `Printed`, all of them texts: `paper` is quoted, with all its digits.

    Raises
    ------
    ConfigError
        If a row is not one, or a key comes twice.
    """
    path = Path(__file__).parent / f"{name}.yaml"
    if not path.exists():
        return ()
    rows = YAML(typ="safe", pure=True).load(path.read_text("utf-8")) or []
    for row in rows:
        if not set(row) <= set(FIELDS) or not all(isinstance(value, str) for value in row.values()):
            raise ConfigError(f"{row} is no row", str(path), f"texts under {', '.join(FIELDS)}")
    printed = tuple(Printed(**row) for row in rows)
    if len({row.key for row in printed}) < len(printed):
        raise ConfigError("a key comes twice", str(path))
    return printed
