"""What `paper --quick` changes in the configs: grids and times so small that everything takes a minute."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

CHANGES: Mapping[str, Sequence[str]] = {}
