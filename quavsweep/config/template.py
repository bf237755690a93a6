"""A commented config for a model: what `quavsweep init` writes."""

from __future__ import annotations

from quavsweep.config.json_schema import describe
from quavsweep.models import NAMES, Example, Model, State

_TEXT = """\
# A sweep of {model}: {source}.
# Run it with `quavsweep run {name}.yaml{option}`; `--dry-run` says how long that takes.
name: {name}  # letters, digits, . _ -; results go to results/{name}
model: {model}

# Parameters that differ from the model's defaults. All of them, with their defaults:
{parameters}
parameters: {{}}

# The state at t = 0; every state that is no axis.
initial:
{initial}

# What varies: parameters or initial states, any number of them, the last one fastest.
# Each is {{start, stop, num}}, with spacing: log if wanted, or {{values: [...]}}.
axes:
{axes}
  # Several that vary together, along a curve: a list or {{start, stop, num}} for each
  # curve: {{zip: {{NAME: [1, 2, 3], OTHER: {{start: 4, stop: 6, num: 3}}}}}}
  # Starts drawn at random, the same ones in every cell; a state in the box is not in initial:
  # ensemble: {{num: 256, seed: 1, box: {{{state}: [-1, 1]}}}}

# Times are in {time}. Transient and duration become whole segments{forced}.
integrate:
  method: rk4  # or dp8, of order 8: longer steps, for small errors
  dt: {dt:g}  # step
  transient: {transient:g}  # before exponents are averaged
  duration: {duration:g}  # over which they are averaged
  # segment: {segment:g}  # between two looks at a cell
  # tolerance: 0.01  # error of a state, against its magnitude, beyond which a run warns of the step

# What is recorded of each cell.
measures:
{lyapunov}
  # orbit: {{every: {every:g}}}  # the state at even times
  # samples: {{maxima: {state}, max: 100}}  # or section: {{of: {state}, at: 0, direction: up}}, or every: a time
{peak}  # statistics: {{of: [{state}]}}  # mean with its error, least and largest value, changes of sign
  # first_time: {{of: {state}, above: 1, until: {until:g}}}  # when a state first exceeds a value
  # last_time: {{of: {state}, at: 0}}  # when a state last has a value{observables}

# End a cell once its end is certified.
stop_early: true

# Cells whose end is not known then go on, each pass twice as long; of: [undecided, chaos] takes chaos on as well.
# effort: {{max_duration: {longest:g}}}

# What is stored of each cell beside the result: full, or summary for 10^8 cells and more. It takes a fraction of the
# disk, but then thresholds are fixed, and classify, extend, effort and --horizon are not possible.
# evidence: summary

# Thresholds; changing them needs no new integration (quavsweep classify).
classify:
  errors: 3  # an exponent is neutral within so many standard errors
  neutral: 2  # and within so often the departure of its growth from a straight line, over the time averaged
  digits: 1.5  # to which weighted averages along a regular orbit agree
"""
_LYAPUNOV = """\
  lyapunov:
    exponents: {exponents}  # number of exponents, largest first
    block: {block}  # steps between two orthonormalisations
    # last_from_trace: true  # the last exponent from the mean divergence: faster, but without that self-check"""
_NO_LYAPUNOV = """\
  peak: {{of: [{state}]}}  # largest magnitude
  # lyapunov: {{exponents: {exponents}, block: {block}}}  # Lyapunov exponents, largest first"""
_PEAK = "  # peak: {{of: [{state}], until: {until:g}}}  # largest magnitude\n"


def _example(model: Model) -> Example:
    """Return a first sweep of a model that says none: every state at 0.1, a parameter around its default."""
    free = [p for p in model.parameters if p.default and p.name not in model.forcing_arguments]
    ends = {p.name: sorted((0.5 * p.default, 1.5 * p.default)) for p in free[:1]}
    axes = {p.name: (max(ends[p.name][0], p.low), min(ends[p.name][1], p.high), 11) for p in free[:1]}
    return Example(dict.fromkeys(model.state_names, 0.1), axes, dt=0.01, transient=100.0, duration=400.0)


def make_template(model: Model, name: str) -> str:
    """Return the text of a commented config of that name, which runs as it is."""
    example = model.example or _example(model)
    states = {state.name: state for state in model.states}
    parameters = [f"#   {p.name}: {p.default:g}  # {describe(p)}" for p in model.parameters]
    initial = [f"  {name}: {value:g}  # {_in_domain(states[name])}" for name, value in example.initial.items()]
    axes = [
        f"  {name}: {{start: {first:g}, stop: {last:g}, num: {number}}}  # {describe(model.quantity(name))}"
        for name, (first, last, number) in example.axes.items()
    ]
    return _TEXT.format(
        model=model.name,
        option="" if model.name in NAMES else " --model FILE",
        forced=", of whole periods of the forcing" if model.forcing_period else "",
        source=model.source or "its source is not given",
        name=name,
        parameters="\n".join(parameters),
        initial="\n".join(initial),
        axes="\n".join(axes) or "  {}",
        time="units of the model" if model.time_unit == "1" else model.time_unit,
        dt=example.dt,
        transient=example.transient,
        duration=example.duration,
        longest=10 * example.duration,
        segment=(example.transient + example.duration) / 16,
        lyapunov=_lyapunov(model, example),
        peak="" if example.exponents == 0 else _PEAK.format(state=model.state_names[0], until=1000 * example.dt),
        observables=_observables(model),
        state=model.state_names[0],
        every=5 * example.dt,
        until=1000 * example.dt,
    )


def _lyapunov(model: Model, example: Example) -> str:
    """Return the lines of the measure `lyapunov`, or of another one where exponents are not worth their time."""
    exponents = len(model.states) if example.exponents is None else example.exponents
    text = _LYAPUNOV if exponents else _NO_LYAPUNOV
    return text.format(exponents=exponents or len(model.states), block=example.block, state=model.state_names[0])


def _observables(model: Model) -> str:
    """Return lines that list the observables of a model."""
    listed = [f"  #   {o.name}  # {describe(o)}" for o in model.observables]
    return "\n".join(["", "  # Beside states, `of` and `maxima` may name:", *listed] if listed else [])


def _in_domain(state: State) -> str:
    """Return what a state is, and its domain if it has one."""
    return f"{describe(state)}, {state.domain}" if state.limited else describe(state)
