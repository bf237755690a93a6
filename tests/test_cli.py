"""The command line as a user meets it: exit codes, one-line errors, output without a terminal."""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import pty
import re
import signal
import subprocess
import sys
import termios
import time
from pathlib import Path

import pytest

from tests.conftest import YAW

COMMAND = [sys.executable, "-m", "quavsweep"]


def _run(*arguments: object, cwd: Path, **options: object) -> subprocess.CompletedProcess[str]:
    words = [*COMMAND, *map(str, arguments)]
    return subprocess.run(words, cwd=cwd, capture_output=True, text=True, timeout=120, check=False, **options)  # type: ignore[call-overload,no-any-return]


@pytest.fixture
def config(tmp_path: Path) -> Path:
    path = tmp_path / "small.yaml"
    path.write_text(YAW)
    return path


def test_run_status_plot_verify(config: Path, tmp_path: Path) -> None:
    done = _run("run", config, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    out = tmp_path / "results" / "small"
    assert {path.name for path in out.iterdir()} == {
        *("config.yaml", "lock", "log.jsonl", "map.png", "result.h5", "run.json", "shards")
    }
    rows = dict(line.split(maxsplit=1) for line in done.stdout.splitlines())
    lines = {line.split()[0]: line.strip() for line in done.stdout.splitlines()}
    assert rows["sweep"] == "small: quadrotor_yaw, Omega1 9 x c 5 = 45 cells"
    assert rows["result"] == "results/small/result.h5"
    assert rows["map"] == "results/small/map.png"
    for check in ("sum", "zero"):
        assert re.fullmatch(rf"{check} check +(not available: .+|.+ by \S+ 1/s at most)", lines[check])
    assert len(done.stdout.splitlines()) <= 20
    assert all(len(line) <= 80 for line in done.stdout.splitlines())
    assert done.stderr == ""

    status = _run("status", "results/small", cwd=tmp_path)
    assert status.returncode == 0
    assert "2 of 2 done (100.0 % of cells)" in status.stdout
    assert "sink" in status.stdout
    told = json.loads(_run("status", "results/small", "--json", cwd=tmp_path).stdout)
    assert told["complete"] is True
    assert sum(told["regions"].values()) == 45
    assert "complete" in _run("status", "results/small", "--watch", cwd=tmp_path).stdout

    verify = _run("verify", "results/small", cwd=tmp_path)
    assert verify.returncode == 0
    assert "2 shards and a result, nothing damaged" in verify.stdout

    for name in ("map.pdf", "map.svg", "other.png"):
        assert _run("plot", "results/small", "--out", name, cwd=tmp_path).returncode == 0
        assert (tmp_path / name).stat().st_size > 5000
    assert _run("plot", "results/small/result.h5", cwd=tmp_path).returncode == 0


def test_verify_finds_damage_and_run_repairs_it(config: Path, tmp_path: Path) -> None:
    assert _run("run", config, "--no-plot", cwd=tmp_path).returncode == 0
    for victim in (next(tmp_path.rglob("tile-0000001*.h5")), tmp_path / "results" / "small" / "result.h5"):
        good = victim.read_bytes()
        data = bytearray(good)
        data[len(data) // 2] ^= 16
        victim.write_bytes(data)
        verify = _run("verify", "results/small", cwd=tmp_path)
        assert verify.returncode == 6
        assert victim.name in verify.stderr
        if victim.name == "result.h5":
            plot = _run("plot", "results/small", cwd=tmp_path)
            assert plot.returncode == 6
            assert len(plot.stderr.splitlines()) == 1
        assert _run("run", config, "--no-plot", cwd=tmp_path).returncode == 0
        assert victim.read_bytes() == good


@pytest.mark.parametrize(
    ("arguments", "code", "says"),
    [
        (("run", "none.yaml"), 2, "none.yaml: cannot be read: No such file or directory"),
        (("run", "."), 2, "cannot be read"),
        (("run",), 2, "Missing argument 'CONFIG'"),
        (("run", "small.yaml", "--workers", "0"), 2, "--workers"),
        (("run", "small.yaml", "--out", "small.yaml"), 2, "small.yaml: is not a folder"),
        (("run", "small.yaml", "--out", "small.yaml/x"), 2, "is not a folder"),
        (("run", "small.yaml", "--out", "/proc/x"), 74, "/proc/x: cannot be written"),
        (("status", "."), 2, "is not the folder of a run"),
        (("verify", "none"), 2, "is not the folder of a run"),
        (("plot", "none"), 2, "is not the folder of a run"),
        (("run", "small.yaml", "--out", ""), 2, "is not a path"),
        (("run", "small.yaml", "--set", "axes.c.num=x"), 2, "--set axes.c.num=x: axes.c.num"),
        (("run", "small.yaml", "--set", "axes"), 2, "KEY=VALUE"),
        (("run", "small.yaml", "--max-time", "soon"), 2, "e.g. 3h50m"),
        (("run", "small.yaml", "--scheduler", ""), 2, "is not the address of a scheduler"),
        (
            ("run", "small.yaml", "--processes", "2", "--workers", "2"),
            2,
            "--processes and --workers exclude each other",
        ),
        (("run", "small.yaml", "--insecure"), 2, "--insecure is for a cluster"),
        (("point", "small.yaml", "Omega1=100"), 2, "c has no value; give Omega1=..., c=..."),
        (("point", "small.yaml", "Omega1"), 2, "is not KEY=NUMBER"),
        (("point", "none.yaml", "c=5"), 2, "cannot be read"),
        (("classify", "."), 2, "is not the folder of a run"),
        (("export", ".", "region"), 2, "give --csv or --nc"),
        (("export", "none", "--csv", "region"), 2, "is not the folder of a run"),
        (("init", "lorentz"), 2, "there is no model lorentz"),
        (("init", "--out", "small.yaml"), 2, "small.yaml: exists already"),
        (("init", "--out", "/proc/x/y.yaml"), 74, "cannot be written"),
        (("plot", "small.yaml"), 2, "is not a result file"),
        (("sing",), 2, "No such command 'sing'"),
    ],
)
def test_errors_are_one_line_and_a_code(config: Path, arguments: tuple[str, ...], code: int, says: str) -> None:
    done = _run(*arguments, cwd=config.parent)
    assert done.returncode == code, done.stderr
    assert says in done.stderr
    assert done.stderr.startswith("quavsweep: ")
    assert len(done.stderr.splitlines()) == 1
    assert "Traceback" not in done.stderr


def test_an_error_in_a_config_names_file_line_and_key(config: Path) -> None:
    config.write_text(YAW.replace("Omega1: {start", "Omga1: {start"))
    done = _run("run", "small.yaml", cwd=config.parent)
    assert done.returncode == 2
    assert done.stderr.startswith("quavsweep: small.yaml:6: axes.Omga1: quavsweep"[:35])
    assert "it has Omega1, c, Ix" in done.stderr


def test_a_folder_of_another_sweep_is_exit_4(config: Path) -> None:
    assert _run("run", config, "--no-plot", cwd=config.parent).returncode == 0
    config.write_text(YAW.replace("dt: 0.02", "dt: 0.01"))
    done = _run("run", config, cwd=config.parent)
    assert done.returncode == 4
    assert "integrate.dt: 0.02 there, 0.01 here" in done.stderr


def test_a_locked_folder_is_exit_5(config: Path) -> None:
    out = config.parent / "results" / "small"
    out.mkdir(parents=True)
    with (out / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        lock.write("process 1 on elsewhere")
        lock.flush()
        done = _run("run", config, cwd=config.parent)
    assert done.returncode == 5
    assert "process 1 on elsewhere" in done.stderr


def test_a_bug_is_exit_1_and_traceback_shows_it(config: Path) -> None:
    code = (
        "import sys, quavsweep.sweep; quavsweep.sweep.run_sweep = lambda *a, **k: 1 / 0;"
        "sys.argv = ['quavsweep', *sys.argv[1:]]; from quavsweep.cli import main; main()"
    )
    plain = subprocess.run([sys.executable, "-c", code, "run", config], capture_output=True, text=True, check=False)
    assert plain.returncode == 1
    assert "this is a bug in quavsweep: ZeroDivisionError" in plain.stderr
    assert len(plain.stderr.splitlines()) == 1
    words = [sys.executable, "-c", code, "--traceback", "run", config]
    shown = subprocess.run(words, capture_output=True, text=True, check=False)
    assert shown.returncode == 1
    assert "Traceback" in shown.stderr


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_stops_the_run_and_it_goes_on(config: Path, number: signal.Signals) -> None:
    config.write_text(YAW.replace("num: 9", "num: 40").replace("num: 5", "num: 20").replace("600", "6000"))
    out = config.parent / "results" / "small"
    words = [*COMMAND, "run", str(config), "--no-plot"]
    with subprocess.Popen(words, cwd=config.parent, stderr=subprocess.PIPE, text=True) as child:
        while not list(out.rglob("tile-*.h5")):
            time.sleep(0.01)
        began = time.monotonic()
        child.send_signal(number)
        _, stderr = child.communicate(timeout=20)
    assert time.monotonic() - began < 3
    assert child.returncode == 75
    assert "the same command continues it" in stderr
    status = _run("status", out, cwd=config.parent)
    assert "not written yet" in status.stdout
    if number == signal.SIGINT:
        assert _run("plot", out, cwd=config.parent).returncode == 0
        assert _run("run", config, "--no-plot", cwd=config.parent).returncode == 0


def test_a_run_under_nohup_does_not_hear_of_the_end_of_its_terminal(config: Path) -> None:
    words = ["nohup", *COMMAND, "run", str(config), "--no-plot"]
    quiet = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    with subprocess.Popen(words, cwd=config.parent, **quiet) as child:  # type: ignore[call-overload]
        while child.poll() is None and not (config.parent / "results" / "small" / "config.yaml").exists():
            time.sleep(0.01)
        child.send_signal(signal.SIGHUP)
        assert child.wait(timeout=60) == 0


def test_max_time_stops_the_run_and_it_goes_on(config: Path) -> None:
    config.write_text(YAW.replace("num: 9", "num: 60").replace("num: 5", "num: 40").replace("600", "6000"))
    words = ["run", config, "--no-plot", "--max-time", "1.5s"]
    done = _run(*words, cwd=config.parent)
    assert done.returncode == 75, done.stderr
    assert "the same command continues it" in done.stderr
    status = _run("status", "results/small", cwd=config.parent)
    assert "nobody is running it" in status.stdout
    watch = _run("status", "results/small", "--watch", cwd=config.parent)
    assert watch.returncode == 75


def test_a_dry_run_says_what_a_run_would_do(config: Path) -> None:
    done = _run("run", config, "--dry-run", "--set", "axes.c.num=9", cwd=config.parent)
    assert done.returncode == 0, done.stderr
    assert "= 81 cells" in done.stdout
    assert re.search(r"tiles +0 valid, 3 missing, 0 bad", done.stdout)
    assert re.search(r"time +about \S+ s with 2 workers", done.stdout)
    assert not (config.parent / "results").exists()


def test_one_cell_is_that_of_the_map(config: Path) -> None:
    assert _run("run", config, "--no-plot", cwd=config.parent).returncode == 0
    done = _run("point", "results/small", "Omega1=275", "c=5", cwd=config.parent)
    assert done.returncode == 0, done.stderr
    assert "cell [4, 2]: equal to the bit" in done.stdout
    assert (config.parent / "results" / "small" / "point.png").stat().st_size > 5000
    assert all(len(line) <= 80 for line in done.stdout.splitlines())
    beside = _run("point", config, "Omega1=276", "c=5", "--no-plot", cwd=config.parent)
    assert "none of the grid" in beside.stdout


def test_labels_tables_and_templates(config: Path) -> None:
    assert _run("run", config, "--no-plot", cwd=config.parent).returncode == 0
    done = _run("classify", "results/small", "--set", "classify.neutral=1", cwd=config.parent)
    assert done.returncode == 0, done.stderr
    assert "nothing had to be integrated" in done.stdout
    table = _run("export", "results/small", "--csv", "region", "lyapunov", "--out", "-", cwd=config.parent)
    assert table.stdout.startswith("Omega1,c,region,lyapunov_1,lyapunov_2,lyapunov_3\n50.0,3.0,sink,-0.02")
    assert len(table.stdout.splitlines()) == 46
    assert _run("export", "results/small", "--nc", "region", cwd=config.parent).stdout == "results/small/region.nc\n"
    assert _run("init", "lorenz", cwd=config.parent).returncode == 0
    assert _run("run", "lorenz.yaml", "--dry-run", cwd=config.parent).returncode == 0
    schema = _run("schema", cwd=config.parent)
    assert json.loads(schema.stdout)["title"] == "quavsweep config"


def test_completion_for_shells(tmp_path: Path) -> None:
    environment = {
        **os.environ,
        "_QUAVSWEEP_COMPLETE": "bash_complete",
        "COMP_WORDS": "quavsweep st",
        "COMP_CWORD": "1",
    }
    assert "status" in _run(cwd=tmp_path, env=environment).stdout


def test_a_terminal_shows_a_bar(config: Path) -> None:
    main, side = pty.openpty()
    termios.tcsetwinsize(side, (24, 80))
    words = [*COMMAND, "run", str(config), "--no-plot"]
    with subprocess.Popen(words, cwd=config.parent, stdout=subprocess.PIPE, stderr=side, text=True) as child:
        os.close(side)
        shown = b""
        with contextlib.suppress(OSError):
            while data := os.read(main, 4096):
                shown += data
        stdout, _ = child.communicate(timeout=60)
    os.close(main)
    assert child.returncode == 0, shown
    assert b"45/45 cells" in shown
    assert "results/small/result.h5" in stdout


def test_machine_code_that_is_damaged_is_made_again(config: Path, tmp_path: Path) -> None:
    environment = {**os.environ, "QUAVSWEEP_CACHE": str(tmp_path / "cache")}
    assert _run("run", config, "--no-plot", "--out", "a", cwd=tmp_path, env=environment).returncode == 0
    files = [path for path in (tmp_path / "cache").rglob("kernel_*") if path.suffix in (".nbi", ".nbc")]
    assert len(files) >= 2
    for path in files:
        path.write_bytes(b"")
    done = _run("run", config, "--no-plot", "--out", "b", cwd=tmp_path, env=environment)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "a" / "result.h5").read_bytes() == (tmp_path / "b" / "result.h5").read_bytes()


def test_without_arguments_help_is_shown(tmp_path: Path) -> None:
    done = _run(cwd=tmp_path)
    assert done.returncode == 0
    assert done.stdout.startswith("Usage: quavsweep")
    assert done.stderr == ""


def test_a_warning_does_not_stop_a_run(config: Path) -> None:
    config.write_text(YAW.replace("c: {start: 3, stop: 7, num: 5}", "Ix: {values: [3.0e-5, 4.9e-3]}"))
    done = _run("run", config, "--no-plot", cwd=config.parent)
    assert done.returncode == 0
    assert "small.yaml: Iy <= Ix + Iz does not hold in 50 % of the cells" in done.stderr


def test_help_loads_nothing_heavy() -> None:
    code = (
        "import sys; sys.argv = ['quavsweep', '--help']\n"
        "from quavsweep.cli import _main\n_main()\n"
        "heavy = {'numpy', 'numba', 'h5py', 'dask', 'matplotlib', 'sympy', 'pydantic'} & set(sys.modules)\n"
        "sys.exit(repr(heavy) if heavy else 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "quavsweep run quadrotor_yaw.yaml" in done.stdout


def test_output_that_nobody_reads(config: Path) -> None:
    done = subprocess.run(
        f"{' '.join(COMMAND)} run small.yaml --no-plot >&- 2>&-", shell=True, cwd=config.parent, check=False
    )
    assert (config.parent / "results" / "small" / "result.h5").exists(), done


def test_a_table_that_nobody_reads_to_its_end(config: Path) -> None:
    assert _run("run", config, "--set", "axes.c.num=200", "--no-plot", cwd=config.parent).returncode == 0
    words = (
        f"{' '.join(COMMAND)} export results/small --csv region lyapunov --out - | head -c 5; exit ${{PIPESTATUS[0]}}"
    )
    done = subprocess.run(["bash", "-c", words], cwd=config.parent, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "Omega", "")


def test_numbers_that_are_none_and_a_damaged_result_are_told(config: Path) -> None:
    assert _run("run", config, "--no-plot", cwd=config.parent).returncode == 0
    for words in (("--horizon", "nan"), ("--horizon", "inf"), ("--variable", "lyapunov", "--limits=-inf,inf")):
        done = _run("plot", "results/small", *words, cwd=config.parent)
        assert done.returncode == 2, done.stderr
    result = config.parent / "results/small/result.h5"
    data = bytearray(result.read_bytes())
    data[len(data) // 2] ^= 1
    result.write_bytes(data)
    told = _run("status", "results/small", cwd=config.parent).stdout
    assert "run the sweep again to rebuild it" in " ".join(told.split())
    assert json.loads(_run("status", "results/small", "--json", cwd=config.parent).stdout)["damaged"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_long_point_is_left_at_a_signal(config: Path, number: signal.Signals) -> None:
    words = [*COMMAND, "point", str(config), "Omega1=240", "c=5", "--no-plot"]
    config.write_text(YAW.replace("duration: 600", "duration: 6000000"))
    with subprocess.Popen(words, cwd=config.parent, stderr=subprocess.PIPE, text=True) as child:
        time.sleep(3)
        began = time.monotonic()
        child.send_signal(number)
        _, stderr = child.communicate(timeout=20)
    assert time.monotonic() - began < 3
    assert (child.returncode, stderr) == (75, "quavsweep: the run was stopped; the same command begins anew\n")


def test_environment_of_a_batch_job(config: Path) -> None:
    done = _run("run", config, cwd=config.parent, env={**os.environ, "LANG": "C", "COLUMNS": "20"})
    assert done.returncode == 0
