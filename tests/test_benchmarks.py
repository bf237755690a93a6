"""The benchmark suite: its command line, its verdicts, what it does without a peer or a compiler; never a speed."""

from __future__ import annotations

import json
import sys
import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from benchmarks.__main__ import main, run
from benchmarks.assembly import hottest_loop, kinds
from benchmarks.catalogue import ROWS, SUITES, select
from benchmarks.cells import make_cells, yaw_cells
from benchmarks.kernel import Naive
from benchmarks.picture import draw_bars, draw_curves
from benchmarks.printed import Printed
from benchmarks.protocol import QUICK, Contender, Protocol, compare
from benchmarks.reference import reference_state
from benchmarks.report import WIDTH, record, table
from benchmarks.row import Measurement, Outcome, Row, at_least, at_most, verdict
from quavsweep.models import load_model

TWO = Measurement([1.9, 2.0, 2.2], {"a": [3.8, 4.0, 4.4], "b": [2.0, 2.0, 2.0]}, note="a word of explanation " * 9)
ROW = Row("some", "kernel", "some row", "x", at_least(1.5), lambda _: TWO, peer="some peer")


def test_an_unknown_suite_is_exit_2_with_the_list(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["kernel", "kernal"]) == 2
    message = capsys.readouterr().err
    assert "kernal" in message
    for suite in SUITES:
        assert suite in message
    for row in ROWS:
        assert row.key in message


def test_rows_are_named_once_and_selected_by_suite_key_or_beginning() -> None:
    keys = [row.key for row in ROWS]
    assert len(set(keys)) == len(keys)
    assert not set(keys) & set(SUITES)
    assert [row.key for row in select([])] == keys
    assert {row.suite for row in select(["kernel"])} == {"kernel"}
    assert [row.key for row in select(["heyoka"])] == ["heyoka-1e-6", "heyoka-1e-9", "heyoka-1e-12"]
    assert [row.key for row in select(["kernel-limit"])] == ["c-limit", "kernel-limit"], "with what may make it void"


def test_a_missing_gcc_is_named_as_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")
    outcomes = run(select(["c-limit", "kernel-c", "kernel-limit", "jitcode"]), QUICK)
    assert [outcome.verdict for outcome in outcomes] == ["missing"] * 5
    assert {outcome.reason for outcome in outcomes} == {"gcc is missing"}


@pytest.mark.parametrize("name", ["dynlib", "pynamicalsys", "heyoka"])
def test_a_missing_peer_is_named_as_missing(
    name: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, name, None)
    assert main([name, "--quick", "--json", str(tmp_path / "out.json")]) == 0
    output = capsys.readouterr().out
    assert f"{name} is missing" in output
    assert "QUICK" in output
    for row in json.loads((tmp_path / "out.json").read_text())["rows"]:
        assert row["verdict"] == "missing"
        assert name in row["reason"]


def test_json_holds_machine_versions_commit_and_every_sample() -> None:
    data = json.loads(json.dumps(record(run([ROW], QUICK), QUICK)))
    machine = data["machine"]
    assert {"processor", "cores", "python", "quavsweep", "gcc"} <= set(machine)
    assert {"numpy", "numba", "llvmlite", "heyoka", "jitcode", "pynamicalsys", "dynlib"} <= set(machine["packages"])
    assert set(machine["commit"]) == {"id", "dirty"}
    assert data["quick"] is True
    assert data["date"]
    (row,) = data["rows"]
    assert row["samples"] == TWO.samples
    assert row["values"] == TWO.values
    assert (row["median"], row["min"], row["max"], row["verdict"]) == (2.0, 1.9, 2.2, "met")


def _outcome(row: Row, judgement: str) -> dict[str, Outcome]:
    return {row.key: Outcome(row, TWO, judgement)}


def test_verdicts() -> None:
    assert verdict(ROW, TWO, {}) == "met"
    assert verdict(replace(ROW, target=at_least(2.1)), TWO, {}) == "missed"
    assert verdict(replace(ROW, target=at_most(2.0)), TWO, {}) == "met"
    assert verdict(replace(ROW, target=at_most(1.9)), TWO, {}) == "missed"
    assert verdict(replace(ROW, target=None), TWO, {}) == "stated"
    assert verdict(ROW, replace(TWO, comparable=False), {}) == "stated"
    c = replace(ROW, key="c-limit")
    needy = replace(ROW, needs="c-limit")
    assert verdict(needy, TWO, _outcome(c, "met")) == "met"
    assert verdict(needy, TWO, _outcome(c, "missed")) == "void"
    assert verdict(needy, TWO, _outcome(c, "missing")) == "void"


def test_an_error_of_one_row_leaves_the_others() -> None:
    def broken(_: Protocol) -> Measurement:
        raise RuntimeError("no luck")

    outcomes = run([replace(ROW, key="broken", measure=broken), ROW], QUICK)
    assert [outcome.verdict for outcome in outcomes] == ["failed", "met"]
    assert "no luck" in outcomes[0].reason


def test_the_table_is_at_most_80_columns_wide() -> None:
    text = table(run([ROW, replace(ROW, key="b", target=None)], QUICK), QUICK)
    assert max(len(line) for line in text.splitlines()) <= WIDTH
    assert "2 (1.9..2.2) x" in text
    assert ">= 1.5 x" in text


def test_samples_are_taken_in_turn_and_warm() -> None:
    calls: list[str] = []
    sides = [Contender(name, lambda name=name: calls.append(name), 2.0, once=True) for name in "ab"]  # type: ignore[misc]
    samples = compare(sides, Protocol(samples=4))
    assert calls == list("abababab")
    assert [len(values) for values in samples.values()] == [4, 4]
    turns: list[str] = []
    sides = [Contender(name, lambda name=name: (turns.append(name), time.sleep(0.02)), 1.0) for name in "ab"]  # type: ignore[misc]
    samples = compare(sides, Protocol(samples=2, seconds=0.1))
    assert [len(values) for values in samples.values()] == [2, 2]
    assert min(min(values) for values in samples.values()) >= 0.02e9
    assert turns.count("a") >= 2 * 0.1 / 0.02
    changes = sum(a != b for a, b in pairwise(turns))
    assert changes >= 6, "within a sample the sides alternate"


def test_the_hottest_loop_is_counted() -> None:
    text = """
    .L1:
        vaddpd  %zmm1, %zmm2, %zmm3
    .L2:
        vfmadd231pd  (%rax), %zmm2, %zmm3
        vmulpd  %zmm1, %zmm2, %zmm3
        vmovapd %zmm1, %zmm2
        jne .L2
        jne .L1
    """
    body = hottest_loop(text)
    assert kinds(body) == {"pd": 2}


def test_the_frozen_naive_loop_computes_what_the_kernel_computes() -> None:
    cells = yaw_cells(20)
    ours, naive = Printed(cells, 3, 0.02, 25, 8), Naive(cells, 0.02, 25, 8)
    ours()
    naive()
    np.testing.assert_allclose(naive.end[:, :3], ours.state(), rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(naive.sums / 4.0, ours.exponents(), rtol=1e-9, atol=1e-9)


def test_reference_orbits_agree_with_small_steps() -> None:
    cells = make_cells(load_model("quadrotor_yaw"), {"Omega1": np.linspace(250.0, 280.0, 3)}, np.full((3, 3), 0.5))
    steps = Printed(cells, 3, 0.001, 100, 20)
    steps()
    np.testing.assert_allclose(reference_state(cells, 2.0), steps.state(), rtol=0, atol=2e-12)


def test_the_pictures_show_every_peer_its_target_and_every_curve() -> None:
    left, right = Figure().subplots(1, 2)
    draw_bars(left, [Outcome(ROW, TWO, "met"), Outcome(replace(ROW, key="x"), None, "missing", "gone")])
    assert [bar.get_width() for bar in left.patches] == [2.0]
    assert [label.get_text() for label in left.get_yticklabels()] == ["some peer"]
    points: list[dict[str, Any]] = [{"error": 10.0**-n, "ns": 10.0 * n} for n in (3, 6, 5)]
    draw_curves(right, {"rk4": points, "heyoka": points})
    assert [len(line.get_xdata()) for line in right.lines] == [2, 2], "beyond the least error there is only rounding"
