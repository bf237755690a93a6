"""A model as data: all that a reader needs to know of it, without its equations as code.

A run of a user's model keeps its description, so that status, plot, verify, classify and export need not run the
user's file. A description is read as what it is, data of unknown origin: every name, number and reference is checked.
"""

from __future__ import annotations

import json
import math
import re
from dataclasses import asdict
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from quavsweep.errors import ModelError
from quavsweep.kernels.described import DescribedModel, no_equations
from quavsweep.kernels.lookup import make_observables, make_program
from quavsweep.kernels.program import OPERATIONS, TIME, TIME_SCALE, Program, Ref
from quavsweep.models import NAMES, Model, Observable, Parameter, Relation, Section, State
from quavsweep.models.model import NAME

LARGEST = 2**23  # bytes
MOST = 1000  # states, parameters, relations
TARGET = r"[a-z][0-9]{1,9}"  # of an assignment
ARITY = {"add": 2, "sub": 2, "mul": 2, "div": 2, "select_less": 4, "select_less_equal": 4}  # else 1

_STRICT = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False, defer_build=True)
Name = Annotated[str, Field(pattern=f"^{NAME}$")]
Text = Annotated[str, Field(pattern=r"^\P{C}*$", max_length=1000)]  # no control characters


class _State(BaseModel):
    model_config = _STRICT
    name: Name
    unit: Text
    symbol: Text
    meaning: Text
    circle: float
    low: float | None = None
    high: float | None = None


class _Parameter(BaseModel):
    model_config = _STRICT
    name: Name
    default: float
    unit: Text
    symbol: Text
    meaning: Text
    low: float | None
    high: float | None
    open_low: bool


class _Observable(BaseModel):
    model_config = _STRICT
    name: Name
    unit: Text
    symbol: Text
    meaning: Text


class _Relation(BaseModel):
    model_config = _STRICT
    text: Text
    meaning: Text


class _Section(BaseModel):
    model_config = _STRICT
    of: Name
    at: float | None
    direction: Text


class _Description(BaseModel):
    model_config = _STRICT
    name: Name
    source: Text
    time_unit: Text
    bound: float
    states: list[_State] = Field(max_length=MOST)
    parameters: list[_Parameter] = Field(max_length=MOST)
    relations: list[_Relation] = Field(max_length=MOST)
    symmetries: list[list[int]] = Field(max_length=MOST)
    section: _Section | None
    program: dict[str, Any]
    observables: list[_Observable] = Field(default=[], max_length=MOST)
    observed: dict[str, Any] | None = None


def describe_model(model: Model) -> str:
    """Return a model as JSON: its quantities, relations' text, symmetries, section, and the program of its equations.

    Raises
    ------
    ModelError
        If the equations cannot be compiled.
    """
    states, parameters = (
        [{**asdict(item), "low": _finite(item.low), "high": _finite(item.high)} for item in items]
        for items in (model.states, model.parameters)
    )  # JSON has no infinity
    observables = [{key: getattr(o, key) for key in _Observable.model_fields} for o in model.observables]
    data = {
        "name": model.name,
        "source": model.source,
        "time_unit": model.time_unit,
        "bound": model.bound,
        "states": states,
        "parameters": parameters,
        "relations": [{"text": relation.text, "meaning": relation.meaning} for relation in model.relations],
        "symmetries": model.symmetries,
        "section": asdict(model.section) if model.section else None,
        "program": json.loads(make_program(model).to_json()),
        "observables": observables,
        "observed": json.loads(make_observables(model).to_json()) if observables else None,
    }
    return json.dumps(data, sort_keys=True, allow_nan=False)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def read_description(text: str | bytes) -> DescribedModel:
    """Return the model that `describe_model` wrote; nothing in the text is run.

    Raises
    ------
    ValueError
        If it is no description of a model, with the reason.
    """
    if len(text) > LARGEST:
        raise ValueError(f"larger than {LARGEST} bytes")
    try:
        data = _Description.model_validate_json(text)
        program = Program.from_json(json.dumps(data.program))
        _check(program)
        observed = Program.from_json(json.dumps(data.observed)) if data.observed is not None else None
        _check_observed(observed, program, len(data.observables))
        return _model(data, program, observed)
    except ValidationError as error:
        first = error.errors()[0]
        raise ValueError(f"{'.'.join(map(str, first['loc']))}: {first['msg']}") from error
    except (ModelError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise ValueError(str(error)) from error


def _model(data: _Description, program: Program, observed: Program | None) -> DescribedModel:
    if data.name in NAMES:
        raise ValueError(f"{data.name} is a model of the catalogue")
    forced = program.forced
    return DescribedModel(
        name=data.name,
        rhs=no_equations,
        states=tuple(State(**_with_ends(state)) for state in data.states),
        parameters=tuple(Parameter(**_with_ends(parameter)) for parameter in data.parameters),
        relations=tuple(Relation(r.text, lambda: True, r.meaning) for r in data.relations),
        symmetries=tuple(tuple(signs) for signs in data.symmetries),
        section=Section(**data.section.model_dump()) if data.section else None,
        forcing_period=no_equations if forced else None,
        bound=data.bound,
        time_unit=data.time_unit,
        source=data.source,
        program=program,
        observables=tuple(Observable(o.name, no_equations, o.unit, o.symbol, o.meaning) for o in data.observables),
        observed=observed,
    )


def _with_ends(data: _State | _Parameter) -> dict[str, Any]:
    """Return the fields of a quantity, with infinite ends of its domain where it has none."""
    low, high = (-math.inf if data.low is None else data.low), (math.inf if data.high is None else data.high)
    return {**data.model_dump(), "low": low, "high": high}


def _check(program: Program) -> None:
    """Refuse a program of equations that does not hang together: names, operations, order and shapes."""
    known = _check_assignments(program)
    size = len(program.states)
    _hold(len(program.rhs) == len(program.jacobian) == len(program.hessian) == size > 0, "a shape is wrong")
    _hold(all(len(row) == size for row in program.jacobian), "a shape is wrong")
    _hold(all(len(matrix) == size and all(len(row) == size for row in matrix) for matrix in program.hessian), "a shape")
    hessian = (ref for matrix in program.hessian for row in matrix for ref in row)
    for ref in (*program.rhs, *(ref for row in program.jacobian for ref in row), *hessian, program.period):
        _check_ref(ref, known)


def _check_observed(observed: Program | None, program: Program, count: int) -> None:
    """Refuse a program of observables that does not hang together, or is not of the same quantities."""
    _hold((observed is not None) == (count > 0), "observables have a program, and nothing else has one")
    if observed is None:
        return
    known = _check_assignments(observed)
    _hold((observed.states, observed.parameters) == (program.states, program.parameters), "observables are of others")
    _hold(observed.forced == program.forced and len(observed.rhs) == 2 * count, "a shape is wrong")
    _hold(not observed.coefficients and not observed.jacobian and not observed.hessian, "a shape is wrong")
    for ref in (*observed.rhs, observed.period):
        _check_ref(ref, known)


def _check_assignments(program: Program) -> set[str]:
    """Refuse names, operations and an order that are wrong; return all names that have a value."""
    known = {TIME_SCALE, *([TIME] if program.forced else [])}
    for names, prefix in ((program.states, "u_"), (program.parameters, "p_")):
        for name in names:
            _hold(
                isinstance(name, str) and name.startswith(prefix) and name not in known, "a name is wrong or repeated"
            )
            known.add(name)
    for assignment in program.assignments:
        target, operation, arguments = assignment.target, assignment.operation, assignment.arguments
        _hold(
            isinstance(target, str) and re.fullmatch(TARGET, target) is not None and target not in known,
            "a target is wrong or repeated",
        )
        _hold(isinstance(operation, str) and operation in OPERATIONS, "an operation is unknown")
        _hold(len(arguments) == ARITY.get(operation, 1), f"{operation} has a wrong number of arguments")
        for ref in arguments:
            _check_ref(ref, known)
        known.add(target)
    _hold(all(isinstance(name, str) and name in known for name in program.coefficients), "a coefficient is unknown")
    return known


def _check_ref(ref: Ref, known: set[str]) -> None:
    number = isinstance(ref, float) and math.isfinite(ref)
    _hold(number or (isinstance(ref, str) and ref in known), "a reference leads nowhere")


def _hold(condition: bool, otherwise: str) -> None:
    if not condition:
        raise ValueError(f"program: {otherwise}")
