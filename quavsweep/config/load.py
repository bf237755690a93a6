"""From a YAML file to a Sweep; what is wrong is told by file, line, key and what is possible."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pydantic import ValidationError

from quavsweep.config.axes import check_domains, make_grid
from quavsweep.config.change import apply_changes
from quavsweep.config.complaint import first_error
from quavsweep.config.document import MAX_BYTES, read_config
from quavsweep.config.ensemble import check_ensemble
from quavsweep.config.explanation import explained
from quavsweep.config.forcing import forcing_period, in_step, shortened
from quavsweep.config.model import described_beside, own_model
from quavsweep.config.place import Keys, Place, quoted
from quavsweep.config.relation import broken_relations
from quavsweep.config.schema import ENSEMBLE, Config
from quavsweep.config.sweep import Sweep
from quavsweep.config.syntax import UnreadableError
from quavsweep.config.times import check_effort, choose_clock, rounding
from quavsweep.config.zipped import check_names
from quavsweep.errors import DISK_ERRNOS, ConfigError, DiskError, ModelError
from quavsweep.measures import Verdict
from quavsweep.models import POSSIBLE, Model, load_model
from quavsweep.nearest import nearest


def load_sweep(path: Path | str, changes: Sequence[str] = (), model: Model | Path | str | None = None) -> Sweep:
    """Return the sweep that a YAML file describes.

    Parameters
    ----------
    path : Path
    changes : sequence of str
        Overrides like "axes.c.num=101"; "axes.c=" removes a key.
    model : Model or Path, optional
        One that is not of the catalogue, or the Python file that makes it. The config of a run's folder does without:
        beside it lies the model's description, which is enough for all but integrating.

    Raises
    ------
    ConfigError
        With file, line and key, if anything in it cannot be read or does not make sense.
    ModelError
        If the model cannot be made or compiled.
    DamageError
        If the description cannot be read.
    """
    path = Path(path)
    try:
        with path.open("rb") as file:
            text = file.read(MAX_BYTES + 1)
    except OSError as error:
        kind = DiskError if error.errno in DISK_ERRNOS else ConfigError
        raise kind(f"cannot be read: {error.strerror}", str(path)) from error
    if len(text) > MAX_BYTES:
        raise ConfigError(f"is larger than {MAX_BYTES} bytes", str(path))
    return parse_sweep(text, str(path), changes, model or described_beside(path))


def parse_sweep(
    text: str | bytes,
    where: str = "config",
    changes: Sequence[str] = (),
    model: Model | Path | str | None = None,
) -> Sweep:
    """Return the sweep that a YAML text describes, as `load_sweep` does; `where` names the text in errors.

    Raises
    ------
    ConfigError
        See `load_sweep`.
    """
    try:
        document = read_config(text, where)
    except UnreadableError as error:
        raise explained(error) from error
    apply_changes(document, [changes] if isinstance(changes, str) else changes)
    try:
        config = Config.model_validate(document.tree)
    except ValidationError as error:
        raise first_error(error, document) from error
    return _check(config, document.place, model)


def _model(name: str, given: Model | Path | str | None, place: Place) -> Model:
    """Return the model that a config names: the one that is given, or one of the catalogue."""
    if given is None:
        try:
            return load_model(name)
        except ModelError as error:
            raise place.error(("model",), f"there is no model {quoted(name)}", POSSIBLE) from error
    model = own_model(given)
    if model.name != name:
        raise place.error(("model",), f"{quoted(name)} is not the model that is given", f"it is {model.name}")
    return model


def _check(config: Config, place: Place, given: Model | Path | str | None) -> Sweep:
    """Check what a schema cannot: names, domains, sizes, clocks."""
    model = _model(config.model, given, place)
    _check_names(config, model, place)
    check_names(config, model, place)
    check_ensemble(config, model, place)
    _check_fixed(config, place)
    _check_initial(config, model, place)
    grid = make_grid(config, model, place)
    fixed = {n: float(config.parameters.get(n, d)) for n, d in model.defaults.items() if n not in config.varied}
    check_domains(model, fixed, config, grid, place)
    config = _with_verdict(config, model)
    asked, (config, period_steps) = config, in_step(config, forcing_period(model, fixed, grid, place), place)
    clock = choose_clock(config, place, period_steps)
    check_effort(config, clock, place)
    problem = config.measures.problem(model, clock)
    if problem is not None:
        raise place.error(("measures", *problem.key.split(".")), problem.what, problem.possible)
    measures = config.measures.rounded(model, clock)
    warnings = (
        *shortened(asked, config, period_steps),
        *rounding(config.integrate, clock),
        *config.measures.changes(measures),
        *broken_relations(model, fixed, grid),
    )
    config = config.model_copy(update={"measures": measures})
    return Sweep(config, model, grid, clock, fixed, warnings)


def _with_verdict(config: Config, model: Model) -> Config:
    """Return the config with a verdict where initial states vary and nothing else would tell chaos."""
    starts, measures = config.varied.keys() & set(model.state_names), config.measures
    if not starts or measures.lyapunov or measures.verdict:
        return config
    return config.model_copy(update={"measures": measures.model_copy(update={"verdict": Verdict()})})


def _check_names(config: Config, model: Model, place: Place) -> None:
    states, parameters = model.state_names, model.parameter_names
    axes: list[tuple[str, ...]] = [("axes", name) for name in config.axes if name not in (ENSEMBLE, *config.zipped)]
    axes += [("axes", axis, "zip", name) for axis, section in config.zipped.items() for name in section.zip or ()]
    for keys, known, what in (
        *((("parameters", name), parameters, "parameter") for name in config.parameters),
        *((("initial", name), states, "state") for name in config.initial),
        *((keys, (*parameters, *states), "parameter or state") for keys in axes),
    ):
        if keys[-1] not in known:
            more = "; ensemble draws starts, {zip} varies several together" if len(keys) == 2 and keys in axes else ""
            raise place.error(
                keys,
                f"{model.name} has no such {what}{nearest(keys[-1], known)}",
                f"it has {', '.join(known)}{more}",
            )


def _check_fixed(config: Config, place: Place) -> None:
    """Refuse a parameter or state that is fixed and varies."""
    for section in ("parameters", "initial"):
        for name in getattr(config, section):
            if name in config.varied:
                keys: Keys = (section, name)
                axis = place.other(config.varied[name], keys)
                raise place.error(keys, f"is fixed here and varied in {axis}", "keep one of the two")


def _check_initial(config: Config, model: Model, place: Place) -> None:
    """Refuse an initial state that is not complete."""
    missing = [name for name in model.state_names if name not in config.initial and name not in config.varied]
    if not missing:
        return
    if not place.has(("initial",)):
        raise place.error(("initial",), "is missing", f"give {', '.join(missing)}, or vary them in axes")
    first, *others = missing
    named = f", so {'is' if len(others) == 1 else 'are'} {', '.join(others)}" if others else ""
    axes = f" in {place.other(('axes',), ('initial', first))}" if place.has(("axes",)) else ""
    raise place.error(("initial", first), f"is missing{named}", f"give it here, or vary it as axes.{first}{axes}")
