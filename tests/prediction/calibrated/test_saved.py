"""A camera written and read is the same camera, and what is none is refused in one line."""

from __future__ import annotations

import json
import zipfile

import numpy as np
import pytest

import bayescal as bc
from bayescal.errors import InputError
from bayescal.prediction.calibrated.saved import camera_bytes, load_camera
from tests.helpers.cameras import turned_points
from tests.helpers.command import apart

POINTS = np.array([[300.0, 60.0, 250.0], [310.0, 80.0, 300.0]])


def test_a_saved_camera_predicts_the_same(thesis_comparison, tmp_path):
    camera = bc.camera(thesis_comparison)
    bc.keep_camera(camera, tmp_path / "camera.npz")
    again = load_camera(tmp_path / "camera.npz")
    for average in (True, False):
        one, two = (bc.predict(c, POINTS, average=average) for c in (camera, again))
        np.testing.assert_array_equal(one.mean, two.mean)
        np.testing.assert_array_equal(one.upper, two.upper)
    assert camera_bytes(again) == camera_bytes(camera)
    assert (tmp_path / "camera.npz").stat().st_size < 1e6


def test_a_saved_pinhole_projects_the_same(tmp_path):
    camera = bc.camera(bc.fit_family(turned_points(0.3), "pinhole", (1,), ess=100))
    bc.keep_camera(camera, tmp_path / "camera.npz")
    again = load_camera(tmp_path / "camera.npz")
    world = turned_points(0.0).world
    np.testing.assert_array_equal(bc.predict(again, world).mean, bc.predict(camera, world).mean)


def test_a_run_answers_without_its_draws(thesis_comparison, tmp_path):
    """The camera of a run is that of its result; without the file it is made again."""
    bc.save_run(thesis_comparison, tmp_path / "run")
    first = bc.predict(tmp_path / "run", POINTS)
    np.testing.assert_array_equal(first.mean, bc.predict(thesis_comparison, POINTS).mean)
    (tmp_path / "run" / "camera.npz").unlink()
    again = bc.predict(tmp_path / "run", POINTS)
    np.testing.assert_allclose(again.mean, first.mean, rtol=1e-12)


def test_the_first_answer_samples_and_plots_nothing(thesis_comparison, tmp_path):
    """What takes long to import stays out: no sampler, no ArviZ, no HDF5, no matplotlib."""
    bc.save_run(thesis_comparison, tmp_path / "run")
    (tmp_path / "p.csv").write_text("x,y,z\n300,60,250\n")
    (tmp_path / "sitecustomize.py").write_text(
        "import sys\n"
        "for name in ('emcee', 'arviz_base', 'arviz_stats', 'h5py', 'matplotlib', 'pandas'):\n"
        "    sys.modules[name] = None\n"  # importing it fails
    )
    import os

    path = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    done = apart("predict", "run", "p.csv", folder=tmp_path, PYTHONPATH=_with_package(path))
    assert done.returncode == 0, done.stderr
    assert b"1 point" in done.stdout


def _with_package(path: str) -> str:
    import os
    from pathlib import Path

    return os.pathsep.join([path, str(Path(bc.__file__).resolve().parents[1])])


def test_a_spoilt_camera_is_refused(thesis_comparison, tmp_path):
    bc.save_run(thesis_comparison, tmp_path / "run")
    file = tmp_path / "run" / "camera.npz"
    raw = file.read_bytes()
    file.write_bytes(raw[:-1] + b"x")
    with pytest.raises(InputError, match="is not what was written there"):
        bc.camera(tmp_path / "run")


def test_what_is_no_camera_is_refused(tmp_path):
    place = tmp_path / "camera.npz"
    with pytest.raises(InputError, match="no such file"):
        load_camera(place)
    place.write_text("x,y,z\n")
    with pytest.raises(InputError, match="is no camera file"):
        load_camera(place)
    np.savez(place, pixel_hull=np.zeros(2))
    with pytest.raises(InputError, match="is no camera file"):
        load_camera(place)
    np.savez(place, camera=np.array([{"pickled": 1}], dtype=object))
    with pytest.raises(InputError, match="is no camera file"):
        load_camera(place)
    with pytest.raises(InputError, match="is no camera file"):
        bc.camera(tmp_path)
    place.unlink()
    with pytest.raises(InputError, match="not a run"):
        bc.camera(tmp_path)


def test_a_later_schema_is_named(thesis_comparison, tmp_path):
    place = tmp_path / "camera.npz"
    bc.keep_camera(bc.camera(thesis_comparison), place)
    with np.load(place) as kept:
        arrays = dict(kept)
    head = json.loads(arrays["camera"].tobytes()) | {"schema": "bayescal-camera-9"}
    arrays["camera"] = np.frombuffer(json.dumps(head).encode(), dtype=np.uint8)
    np.savez(place, **arrays)
    assert zipfile.is_zipfile(place)
    with pytest.raises(InputError, match="schema 'bayescal-camera-9'"):
        load_camera(place)
