"""Files that a user names for what is written: whole or not at all, and nothing else is replaced by them."""

from __future__ import annotations

import contextlib
import os
import threading
from pathlib import Path

import pytest

from quavsweep.cli import main
from quavsweep.config import parse_sweep
from quavsweep.errors import DiskError
from quavsweep.sweep import run_sweep
from quavsweep.whole import binary_file, plain_file, text_file
from tests.conftest import YAW


def test_what_raises_leaves_the_old_file_and_no_other(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    path.write_text("precious")
    with contextlib.suppress(KeyboardInterrupt), text_file(path) as stream:
        stream.write("half")
        raise KeyboardInterrupt
    assert path.read_text() == "precious"
    assert [*tmp_path.iterdir()] == [path]
    with text_file(path) as stream:
        stream.write("all\n")
    assert path.read_bytes() == b"all\n"


def test_a_link_stays_and_what_it_leads_to_is_written(tmp_path: Path) -> None:
    target, link = tmp_path / "target", tmp_path / "link"
    link.symlink_to(target)
    for text in (b"1", b"2"):
        with binary_file(link) as raw:
            raw.write(text)
    assert link.is_symlink()
    assert target.read_bytes() == b"2"


def test_a_pipe_is_written_to(tmp_path: Path) -> None:
    pipe, heard = tmp_path / "pipe", list[bytes]()
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: heard.append(pipe.read_bytes()))
    reader.start()
    with binary_file(pipe) as raw:
        raw.write(b"told")
    reader.join(10)
    assert heard == [b"told"]
    assert pipe.is_fifo()


@pytest.mark.parametrize(("name", "says"), [("folder", "Is a directory"), ("none/file", "No such file")])
def test_what_cannot_be_written_is_told_by_its_name(name: str, says: str, tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    with pytest.raises(DiskError, match=f"{name}: cannot be written: {says}"), binary_file(tmp_path / name):
        pass
    assert [path.name for path in tmp_path.iterdir()] == ["folder"]


def test_only_a_plain_file_is_read(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"plain")
    (tmp_path / "link").symlink_to("file")
    os.mkfifo(tmp_path / "pipe")
    with plain_file(tmp_path / "file") as file:
        assert file.read() == b"plain"
    for name in ("link", "pipe", "."):
        with pytest.raises(OSError, match=r"symbolic links|is not a file"), plain_file(tmp_path / name):
            pass


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (("--csv", "nonsense", "--out", "kept"), 2),
        (("--nc", "region", "--out", "pipe"), 2),
        (("--nc", "region", "--out", "folder"), 2),
        (("--csv", "region", "--out", "folder"), 74),
        (("--nc", "nonsense", "--out", "kept"), 2),
    ],
)
def test_an_export_that_is_refused_touches_nothing(
    arguments: tuple[str, ...], code: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run_sweep(parse_sweep(YAW.replace("num: 9", "num: 2").replace("num: 5", "num: 2")), tmp_path / "run")
    (tmp_path / "kept").write_text("precious")
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.argv", ["quavsweep", "export", "run", *arguments])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == code
    assert (tmp_path / "kept").read_text() == "precious"
    assert (tmp_path / "pipe").is_fifo()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["folder", "kept", "pipe", "run"]
