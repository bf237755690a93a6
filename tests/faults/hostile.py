"""Attack F34: hostile HDF5 files that bear a valid seal, given to the readers."""

from __future__ import annotations

import io
import json
import time
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path

import h5py
import numpy as np

from quavsweep.errors import ConfigError, DamageError, QuavsweepError
from quavsweep.plot import make_figure
from quavsweep.result import Result, open_result
from quavsweep.store import check_result
from tests.faults.mutant import SEAL, Mutants, sealed, small_result

CANARY = np.frombuffer(bytes((7, 1, 6, 2, 5, 3)) + b"canary-0123456789", np.int8)  # begins as regions could
SECONDS = 60
MEMORY = 2**31  # bytes
DRAWN = 0.02  # share of the mutants that are drawn if they can be read
VERIFIED = 0.2  # and of those that bear the digest of their content and are verified
Corrupt = Callable[[h5py.File, Path], None]


def _anew(file: h5py.File, name: str, **options: object) -> None:
    """Put another dataset in the place of a variable, with its dimensions."""
    old = file[name][()]
    shape, kind = old.shape, old.dtype
    del file[name]
    file.create_dataset(name, shape, kind, **options)
    for dim, axis in zip(file[name].dims, ("Omega1", "c"), strict=False):
        dim.attach_scale(file[axis])


def _external_storage(file: h5py.File, folder: Path) -> None:
    _anew(file, "region", external=[(str(folder / "canary"), 0, 6)])


def _external_link(file: h5py.File, folder: Path) -> None:
    del file["region"]
    file["region"] = h5py.ExternalLink(str(folder / "canary.h5"), "/region")


def _soft_link(file: h5py.File, folder: Path) -> None:
    del file["region"]
    file["region"] = h5py.SoftLink("/status")


def _dangling_link(file: h5py.File, folder: Path) -> None:
    file["more"] = h5py.SoftLink("/more")


def _virtual(file: h5py.File, folder: Path) -> None:
    shape = file["region"].shape
    del file["region"]
    layout = h5py.VirtualLayout(shape, np.int8)
    layout[...] = h5py.VirtualSource(str(folder / "canary.h5"), "region", shape)
    file.create_virtual_dataset("region", layout)


def _huge_rank(file: h5py.File, folder: Path) -> None:
    file.create_dataset("more", (1,) * 32, np.int8)


def _huge_shape(file: h5py.File, folder: Path) -> None:
    file.create_dataset("more", (2**40,), np.float64, chunks=(2**20,))


def _bomb(file: h5py.File, folder: Path) -> None:
    chunk = (2**29 - 1,)
    dataset = file.create_dataset("more", chunk, np.int8, chunks=chunk, compression="gzip")
    dataset.id.write_direct_chunk((0,), _deflated(2**30))


def _hidden_bomb(file: h5py.File, folder: Path) -> None:
    """Write a small chunk that is deflated from far more bytes than it has."""
    shape = file["region"].shape
    _anew(file, "region", chunks=shape, compression="gzip")
    file["region"].id.write_direct_chunk((0, 0), _deflated(2**32))


def _deflated(size: int) -> bytes:
    """Return zeros as zlib deflates them, a block of 16 MiB again and again."""
    packer, block = zlib.compressobj(9, zlib.DEFLATED, -15), bytes(2**24)
    packed = packer.compress(block) + packer.flush(zlib.Z_FULL_FLUSH)
    adler = (size % 65521) << 16 | 1
    return b"\x78\xda" + packed * (size // len(block)) + b"\x03\x00" + adler.to_bytes(4, "big")


def _foreign_filter(file: h5py.File, folder: Path) -> None:
    _anew(file, "region", chunks=file["region"].shape, compression="lzf")


def _huge_attribute(file: h5py.File, folder: Path) -> None:
    file["region"].attrs.create("more", np.zeros(2**23, np.int8))


def _huge_text(file: h5py.File, folder: Path) -> None:
    file.attrs["source"] = "x" * 2**25


def _many_attributes(file: h5py.File, folder: Path) -> None:
    for i in range(2000):
        file.attrs[f"a{i}"] = i


def _deep_groups(file: h5py.File, folder: Path) -> None:
    group = file
    for _ in range(3000):
        group = group.create_group("g")


def _cycle(file: h5py.File, folder: Path) -> None:
    file.create_group("g")["g"] = file


def _many_variables(file: h5py.File, folder: Path) -> None:
    for i in range(2000):
        file.create_dataset(f"v{i}", data=0)


def _references(file: h5py.File, folder: Path) -> None:
    file.create_dataset("more", data=np.array([file.ref], dtype=h5py.ref_dtype))


def _compound(file: h5py.File, folder: Path) -> None:
    file.create_dataset("more", data=np.zeros(2, [("a", "i4"), ("b", "f8")]))


def _ragged(file: h5py.File, folder: Path) -> None:
    file.create_dataset("more", (2,), h5py.vlen_dtype(np.int8))


def _named_type(file: h5py.File, folder: Path) -> None:
    file["more"] = np.dtype("f8")


def _growing(file: h5py.File, folder: Path) -> None:
    _anew(file, "region", chunks=file["region"].shape, maxshape=(None, None))


def _code(file: h5py.File, folder: Path) -> None:
    file["region"][0, 0] = 99


def _negative_code(file: h5py.File, folder: Path) -> None:
    file["status"][0, 0] = -1


def _axis(file: h5py.File, folder: Path) -> None:
    file["Omega1"][0] = np.nan


def _other_shape(file: h5py.File, folder: Path) -> None:
    del file["region"]
    file.create_dataset("region", data=np.ones((4, 2), np.int8))


def _text_for_numbers(file: h5py.File, folder: Path) -> None:
    del file["region"]
    file.create_dataset("region", data=["canary"] * 6)


def _no_region(file: h5py.File, folder: Path) -> None:
    del file["region"]


def _terminal(file: h5py.File, folder: Path) -> None:
    file.attrs["title"] = np.bytes_(b"\x1b]0;canary\x07")


def _settings(change: Callable[[dict[str, object]], object]) -> Corrupt:
    def corrupt(file: h5py.File, folder: Path) -> None:
        settings = json.loads(file.attrs["config"])
        text = change(settings)
        file.attrs["config"] = np.bytes_(text if isinstance(text, str) else json.dumps(settings))

    return corrupt


def _axes(**more: object) -> Corrupt:
    return _settings(lambda settings: settings["axes"]["Omega1"].update(more))  # type: ignore[index]


def _described(text: str) -> Corrupt:
    def corrupt(file: h5py.File, folder: Path) -> None:
        file.attrs["model_description"] = np.bytes_(text.encode())

    return corrupt


CORPUS: dict[str, Corrupt] = {
    name.removeprefix("_"): corrupt
    for name, corrupt in (
        *((f.__name__, f) for f in (_external_storage, _external_link, _soft_link, _dangling_link, _virtual)),
        *((f.__name__, f) for f in (_huge_rank, _huge_shape, _bomb, _hidden_bomb, _foreign_filter, _huge_attribute)),
        *((f.__name__, f) for f in (_huge_text, _many_attributes, _deep_groups, _cycle, _many_variables, _references)),
        *((f.__name__, f) for f in (_compound, _ragged, _named_type, _growing, _code, _negative_code, _axis)),
        *((f.__name__, f) for f in (_other_shape, _text_for_numbers, _no_region, _terminal)),
        ("no_config", _settings(lambda _: "")),
        ("config_list", _settings(lambda _: "[]")),
        ("deep_config", _settings(lambda _: "[" * 200_000)),
        ("long_config", _settings(lambda _: '{"a": "' + "x" * 2**21 + '"}')),
        ("long_number", _settings(lambda _: '{"a": ' + "9" * 50_000 + "}")),
        ("million_values", _axes(num=10**6)),
        ("too_many_cells", _axes(num=10**12)),
        ("not_a_number", _axes(start=float("nan"))),
        ("code_for_model", _settings(lambda s: s.update(model="__import__('os').system('touch canary')"))),
        ("odd_description", _described("{}")),
        ("deep_description", _described("[" * 200_000)),
        ("code_description", _described("{\"program\": \"__import__('os').system('touch canary')\"}")),
    )
}


def make_canary(folder: Path) -> None:
    """Write the files that nobody may read."""
    (folder / "canary").write_bytes(CANARY.tobytes())
    with h5py.File(folder / "canary.h5", "w") as file:
        file["region"] = CANARY[:6].reshape(3, 2)


def hostile(name: str, result: bytes, folder: Path) -> Path:
    """Write the hostile file of that name, sealed, and return its path."""
    memory = folder / "raw.h5"
    memory.write_bytes(result[:-SEAL])
    with h5py.File(memory, "r+", libver=("v110", "v110")) as file:
        CORPUS[name](file, folder)
    path = folder / f"{name}.h5"
    path.write_bytes(sealed(memory.read_bytes()))
    return path


def look(path: Path, draw: bool) -> Result:
    """Open a file, read all that is in it, and draw it if wanted; the canary may be nowhere in it."""
    result = open_result(path)
    for name in result.stored.data:
        values = result[name]
        assert CANARY[:6].tobytes() not in values.astype("S" if values.dtype.kind == "O" else values.dtype).tobytes()
        assert values.shape[: len(result.sweep.grid.shape)] == result.sweep.grid.shape or values.ndim == 1
    assert "canary" not in str(result.stored.attributes) + str(result.stored.file_attributes)
    if draw:
        make_figure(result).savefig(io.BytesIO(), dpi=40)
    return result


def attack(n: int, rng: np.random.Generator, folder: Path) -> Iterator[tuple[bool, bool, str, str]]:
    """Yield for each of n resealed mutants whether it was survived, whether it was taken wrongly, its kind, and a note.

    Survived: nothing but a sentence with exit code 2 or 6 comes of it, or a result; in 60 s and 2 GiB. Taken wrongly:
    what another file holds was read, or what is read cannot be of the sweep that the file names.
    """
    mutants = Mutants(small_result(folder / "run"), rng)
    path = folder / "mutant.h5"
    for _ in range(n):
        verified = rng.random() < VERIFIED
        kind, data = mutants.make(digest=verified)
        path.write_bytes(data)
        survived, silent, note = attempt(path, draw=rng.random() < DRAWN, verify=verified)
        yield survived, silent, kind, note


def attempt(path: Path, draw: bool = True, verify: bool = True) -> tuple[bool, bool, str]:
    """Return whether a file was survived, whether it was taken wrongly, and what came of it."""
    begun, silent, before = time.monotonic(), False, _memory("VmRSS")
    Path("/proc/self/clear_refs").write_text("5")  # the peak begins anew: other tests may have taken more
    try:
        look(path, draw)
        if verify:
            check_result(path)
        note = "read"
    except (ConfigError, DamageError) as error:
        note = str(error)
    except AssertionError as error:
        silent, note = True, f"taken wrongly: {error}"
    except QuavsweepError as error:
        return False, False, f"{type(error).__name__}: {error}"
    except Exception as error:
        return False, False, f"a bug: {type(error).__name__}: {error}"
    in_time, taken = time.monotonic() - begun < SECONDS, _memory("VmHWM") - before
    return in_time and taken < MEMORY and all(c.isprintable() for c in note), silent, note


def _memory(name: str) -> int:
    """Return what this process takes of memory, or has taken at most [bytes]."""
    status = Path("/proc/self/status").read_text()
    return int(status.partition(f"{name}:")[2].split()[0]) * 1024
