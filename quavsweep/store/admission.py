"""Which sweeps may use a folder: none but those whose evidence it holds."""

from __future__ import annotations

from quavsweep.config import Sweep, load_sweep
from quavsweep.errors import ConfigError, DamageError, IdentityError
from quavsweep.provenance import Identity, changed_keys, evidence_parts, flatten, toolchain
from quavsweep.store.folder import RunFolder


def check_folder(
    folder: RunFolder, sweep: Sweep, identity: Identity, accept_toolchain: bool = False, longer: bool = False
) -> None:
    """Refuse a folder that holds the evidence of another sweep, engine, model or toolchain.

    With `accept_toolchain` evidence of another toolchain may stay beside that of this one; with `longer` the folder
    may hold a shorter run of the same sweep.

    Raises
    ------
    IdentityError
        With the difference, key by key.
    """
    present = folder.identities()
    if not present and not folder.result.exists():
        return
    if not present or (identity.evidence, identity.toolchain) in present:
        if folder.config.exists():
            _check_config(folder, sweep, longer)
        return
    _check_config(folder, sweep, longer)
    if accept_toolchain and any(evidence == identity.evidence for evidence, _ in present):
        return
    starts = folder.read_starts()
    known = starts[-1] if starts else {}
    before = [value if isinstance(value := known.get(key), dict) else {} for key in ("evidence", "toolchain")]
    differences = changed_keys(before[0], evidence_parts(sweep)) + changed_keys(before[1], toolchain())
    raise IdentityError(
        "holds evidence of another engine, model or toolchain",
        str(folder.path),
        f"{_listed(differences)}; {_way_out(differences)}",
    )


def _way_out(differences: list[str]) -> str:
    """Return what can be done about differences."""
    toolchain_only = bool(differences) and all(d.split(":")[0] in toolchain() for d in differences)
    return f"choose another --out{', or --accept-toolchain to start anew beside it' if toolchain_only else ''}"


def _listed(differences: list[str]) -> str:
    """Return the first differences in a line."""
    more = [f"and {len(differences) - 6} more"] if len(differences) > 6 else []
    return "; ".join([*differences[:6], *more]) or "the difference is not known"


def _check_config(folder: RunFolder, sweep: Sweep, longer: bool) -> None:
    """Refuse a folder whose config differs in what changes a number."""
    try:
        stored = load_sweep(folder.config).settings()
    except (ConfigError, DamageError) as error:
        if not folder.config.exists():
            return
        raise IdentityError(
            f"its config cannot be read ({error})", str(folder.path), "delete that file to have it rebuilt"
        ) from error
    free = ("classify", "effort", *(["integrate.duration"] if longer else [])) if sweep.keeps_evidence else ()
    kept = [
        {k: v for k, v in flatten(settings).items() if not k.startswith(free)}
        for settings in (stored, sweep.settings())
    ]
    differences = changed_keys(*kept)
    if differences:
        fixed = any(difference.startswith("classify.") for difference in differences)
        why = (
            "; with evidence: summary its shards hold what these thresholds gave, so they cannot change"
            if fixed
            else ""
        )
        raise IdentityError(
            "holds a different sweep", str(folder.path), f"{_listed(differences)}{why}; choose another --out"
        )
