"""The schema of configs as JSON Schema, for editors: keys, types, meanings, and each model's quantities and units."""

from __future__ import annotations

from typing import Any

from quavsweep.config.schema import ENSEMBLE, Config
from quavsweep.models import NAMES, Model, Observable, Parameter, State, load_model
from quavsweep.models.model import NAME


def json_schema() -> dict[str, Any]:
    """Return the schema of configs (JSON Schema 2020-12)."""
    schema = Config.model_json_schema()
    schema["properties"]["model"] |= {"anyOf": [{"enum": list(NAMES)}, {"pattern": f"^{NAME}$"}]}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **schema,
        "title": "quavsweep config",
        "allOf": [_of_model(load_model(name)) for name in NAMES],
    }


def _of_model(model: Model) -> dict[str, Any]:
    """Return what holds for configs of a model: the names that its sections may have."""
    parameters = {p.name: _parameter(p) for p in model.parameters}
    states = {s.name: _state(s) for s in model.states}
    quantities: list[State | Parameter] = [*model.parameters, *model.states]
    axes = {q.name: {"$ref": "#/$defs/AxisSection", "description": describe(q)} for q in quantities}
    axes[ENSEMBLE] = {"$ref": "#/$defs/EnsembleSection", "description": "starts drawn from a box; the last axis"}
    sections = {"parameters": parameters, "initial": states, "axes": axes}
    closed = {name: {"properties": properties, "additionalProperties": False} for name, properties in sections.items()}
    return {
        "if": {"properties": {"model": {"const": model.name}}, "required": ["model"]},
        "then": {"properties": closed},
    }


def _parameter(parameter: Parameter) -> dict[str, Any]:
    low = {"exclusiveMinimum" if parameter.open_low else "minimum": parameter.low} if parameter.low > -1e300 else {}
    high = {"maximum": parameter.high} if parameter.high < 1e300 else {}
    return {"type": "number", "default": parameter.default, "description": describe(parameter), **low, **high}


def _state(state: State) -> dict[str, Any]:
    low = {"exclusiveMinimum": state.low} if state.low > -1e300 else {}
    high = {"exclusiveMaximum": state.high} if state.high < 1e300 else {}
    return {"type": "number", "description": describe(state), **low, **high}


def describe(quantity: State | Parameter | Observable) -> str:
    """Return the meaning and unit of a quantity in a line."""
    unit = "" if quantity.unit == "1" else f" [{quantity.unit}]"
    return f"{quantity.meaning or quantity.name}{unit}"
