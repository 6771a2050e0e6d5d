"""Files of views that are broken, or made to harm.

Truth: each ends in one line, or in views; nothing is unpickled, and no more is unpacked than is
stated. Mutations of sound files come from hypothesis.
"""

from __future__ import annotations

import base64
import io
import pickle
import struct
import tracemalloc
import zipfile
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.io import loadmat, savemat

import bayescal as bc
from bayescal.points.views.formats import archive, mat_contents
from tests.helpers.view_files import (
    BOARD,
    IMAGES,
    OBJECTS,
    cameramodel,
    corners_vnl,
    observations,
    packed,
    write_boards,
)


class Trap:
    """Makes a file when it is unpickled."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple[object, ...]:
        return (Path.touch, (self.path,))


def refused(path: Path, **options: object) -> str:
    with pytest.raises(bc.InputError) as caught:
        bc.load_views(path, **options)
    message = str(caught.value)
    assert "\n" not in message
    assert len(message) < 600
    return message


def test_pickles_stay_shut(tmp_path: Path) -> None:
    trap = tmp_path / "sprung"
    held = np.empty(1, dtype=object)
    held[0] = Trap(trap)
    np.savez(tmp_path / "v.npz", imgpoints=held, objpoints=OBJECTS)
    assert "pickled objects, which are never read" in refused(tmp_path / "v.npz")
    np.savez(tmp_path / "w.npz", imgpoints=IMAGES, objpoints=OBJECTS, other=held)
    assert len(bc.load_views(tmp_path / "w.npz")) == 3  # what isn't needed isn't looked at
    inputs = observations() | {"observations_board": held}
    (tmp_path / "c.cameramodel").write_text(cameramodel(packed(**inputs)))
    assert "pickled objects" in refused(tmp_path / "c.cameramodel")
    assert not trap.exists()
    pickle.loads(pickle.dumps(held))  # negative control: it would have sprung
    assert trap.exists()


def npy(shape: str, content: bytes, descr: str = "<f8") -> bytes:
    header = f"{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode() + content


@pytest.mark.parametrize(
    "shape", ["(1000000000000,)", "(2, 3, 99999999999999999999)", "(-1, 3)", "(3,)", "(0, 0)"]
)
def test_shapes_that_lie(tmp_path: Path, shape: str) -> None:
    with zipfile.ZipFile(tmp_path / "v.npz", "w") as file:
        file.writestr("imgpoints.npy", npy(shape, bytes(16)))
    tracemalloc.start()
    refused(tmp_path / "v.npz", board="5x4")
    assert tracemalloc.get_traced_memory()[1] < 100e6
    tracemalloc.stop()


def test_archives_that_swell(tmp_path: Path) -> None:
    path = tmp_path / "v.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("imgpoints.npy", bytes(archive.LARGEST + 1))
    assert path.stat().st_size < 1e6
    assert "MB unpacked, more than the" in refused(path)
    # One that states less than it holds is read to what it states, and found broken.
    raw = bytearray(path.read_bytes())
    at = raw.rindex(b"PK\x01\x02")
    raw[at + 24 : at + 28] = struct.pack("<I", 1000)
    path.write_bytes(raw)
    assert "is no sound .npz" in refused(path)


def test_matlab_files_that_swell(tmp_path: Path) -> None:
    path = tmp_path / "m.mat"
    savemat(path, {"imagePoints": np.moveaxis(IMAGES, 0, 2), "worldPoints": BOARD.points()})
    head = path.read_bytes()[: mat_contents.HEADER]
    packer = zlib.compressobj(1)
    bomb = packer.compress(struct.pack("<II", mat_contents.MATRIX, 2**31))
    for _ in range(mat_contents.LARGEST // 2**20 + 1):
        bomb += packer.compress(bytes(2**20))
    bomb += packer.flush()
    path.write_bytes(head + struct.pack("<II", mat_contents.COMPRESSED, len(bomb)) + bomb)
    assert path.stat().st_size < 2e6
    assert "holds more than 256 MB unpacked" in refused(path)


def test_matlab_values_of_no_known_type(tmp_path: Path) -> None:
    """Such a file ends the process in scipy's reader."""
    path = tmp_path / "m.mat"
    savemat(path, {"X_1": BOARD.points().T, "x_1": IMAGES[0].T})
    raw = bytearray(path.read_bytes())
    raw[177] = 0x16
    path.write_bytes(raw)
    assert "is no sound MATLAB file" in refused(path)


@pytest.mark.parametrize("kind", ["i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8", "i8", "u8"])
def test_matlab_values_are_scipys(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "m.mat"
    values = np.random.default_rng(3).integers(0, 120, (3, 4, 2)).astype(kind)
    savemat(path, {"a": values, "z": 1j * values, "e": np.zeros((0, 2)), "a_cell": {"b": 1}})
    found = mat_contents.numeric_variables("m.mat", path.read_bytes(), lambda _: True)
    assert sorted(found) == ["a", "e"]
    np.testing.assert_array_equal(found["a"], loadmat(path)["a"])
    assert found["e"].shape == (0, 2)


def test_matlab_files_of_other_things(tmp_path: Path) -> None:
    path = tmp_path / "m.mat"
    savemat(path, {"imagePoints": np.array([[1, "x"]], dtype=object), "s": {"a": 1}})
    assert "holds neither Bouguet's X_1" in refused(path)
    path.write_bytes(b"MATLAB 7.3 MAT-file, Platform".ljust(128, b" "))
    assert "version 7.3; save it with -v7" in refused(path)
    path.write_bytes(b"")
    assert "is no MATLAB file of version 5 to 7" in refused(path)


@pytest.mark.parametrize(
    "text",
    [
        "{'lensmodel': " + "[" * 100_000,
        "{'lensmodel': " + "-" * 200_000 + "1}",
        "{'lensmodel': __import__('os').system('true')}",
        "{'lensmodel': 'x', 'icam_intrinsics': -1, 'optimization_inputs': b'00'}",
        "{'lensmodel': 'x', 'icam_intrinsics': 0, 'optimization_inputs': b'~~~~~'}",
        "{'lensmodel': 'x', 'icam_intrinsics': 0, 'optimization_inputs': b'0000'}",
        "'lensmodel'",
        "{'lensmodel': {}: 1}",
        "{[]: 'lensmodel'}",
    ],
)
def test_literals_that_are_none(tmp_path: Path, text: str) -> None:
    (tmp_path / "c.cameramodel").write_text(text)
    refused(tmp_path / "c.cameramodel")


def test_views_of_endless_files() -> None:
    assert "holds more than 64 MB" in refused(Path("/dev/zero"))


def sound(folder: Path) -> dict[str, bytes]:
    """Sound files of each kind, small."""
    np.savez(folder / "v.npz", objpoints=OBJECTS[:2], imgpoints=IMAGES[:2])
    arrays = {f"X_{v}": BOARD.points().T for v in (1, 2)} | {f"x_{v}": IMAGES[v].T for v in (1, 2)}
    savemat(folder / "v.mat", arrays, do_compression=True)
    savemat(folder / "u.mat", arrays)
    (folder / "v.cameramodel").write_text(cameramodel(packed(**observations())))
    (folder / "v.vnl").write_text("\n".join(corners_vnl()))
    bc.save_views(bc.load_views(folder / "v.npz"), folder / "v.csv")
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir()) if path.is_file()}


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, bytes]]:
    folder = tmp_path_factory.mktemp("sound")
    files = sound(folder)
    write_boards(folder)
    return folder, files


def outcome(path: Path, **options: object) -> bc.Views | str:
    """Views of a file, or the line that refuses it."""
    try:
        return bc.load_views(path, **options)
    except bc.InputError as error:
        return str(error)


def sane(found: bc.Views | str) -> bool:
    """Whether it is one line, or views of finite numbers."""
    if isinstance(found, str):
        return "\n" not in found and len(found) < 600
    return bool(np.isfinite(found.pixels).all() and np.isfinite(found.world).all())


def mutated(data: st.DataObject, raw: bytes) -> bytes:
    """Bytes changed, cut out, repeated or cut off."""
    changed = bytearray(raw)
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, max(len(changed) - 1, 0)))
        length = data.draw(st.integers(0, 40))
        kind = data.draw(st.sampled_from(["set", "cut", "twice", "end"]))
        if kind == "set":
            new = data.draw(st.binary(min_size=1, max_size=8))
            changed[at : at + len(new)] = new
        elif kind == "cut":
            del changed[at : at + length]
        elif kind == "twice":
            changed[at:at] = changed[at : at + length]
        else:
            del changed[at:]
    return bytes(changed)


@pytest.mark.parametrize("name", ["v.npz", "v.mat", "u.mat", "v.cameramodel", "v.vnl", "v.csv"])
@settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(data=st.data())
def test_mutations_end_in_views_or_a_line(place, name: str, data: st.DataObject) -> None:
    folder, files = place
    path = folder / ("changed" + Path(name).suffix)
    path.write_bytes(mutated(data, files[name]))
    assert sane(outcome(path, board="5x4" if name == "v.vnl" else None))


@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_mutated_archives_within_a_cameramodel(place, data: st.DataObject) -> None:
    folder, _ = place
    stream = io.BytesIO()
    np.savez(stream, **observations())
    inputs = base64.b85encode(mutated(data, stream.getvalue()))
    (folder / "inner.cameramodel").write_text(cameramodel(inputs))
    assert sane(outcome(folder / "inner.cameramodel"))


@pytest.mark.parametrize("name", ["b.dsc", "b.tp", "corners/im1.orpc"])
@settings(
    max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(data=st.data())
def test_mutated_boards_of_tags(place, name: str, data: st.DataObject) -> None:
    folder, _ = place
    path = folder / name
    raw = path.read_bytes()
    path.write_bytes(mutated(data, raw))
    try:
        assert sane(outcome(folder / "corners"))
    finally:
        path.write_bytes(raw)
