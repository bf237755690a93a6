"""YAML text to a frozen Sweep; every check of a user's input lives here."""

from quavsweep.config.document import dump_config
from quavsweep.config.load import load_sweep, parse_sweep
from quavsweep.config.schema import Config
from quavsweep.config.sweep import Sweep

__all__ = ["Config", "Sweep", "dump_config", "load_sweep", "parse_sweep"]
