"""Cameras written for other tools.

Truth: each tool's own reader and projection (OpenCV, COLMAP), or the format's published form read
by a strict parser (ROS and Kalibr: PyYAML; mrcal: a Python literal) and projected by OpenCV's or
the paper's equations. Tolerance: rounding of doubles, 1e-9 px.
"""

from __future__ import annotations

import ast
import csv
from pathlib import Path

import cv2
import numpy as np
import pycolmap
import pytest
import yaml

import bayescal as bc
from bayescal.cameras.camera import Camera
from bayescal.cameras.lenses import Lens, lens_named
from bayescal.errors import OutputError
from bayescal.report.cameras.camera import SLOTS, FittedCamera
from bayescal.report.cameras.write import BESIDE, FORMATS, camera_text

INTRINSICS = np.array([512.25, 508.5, 321.75, 236.125])
SIZE = (640, 480)
# A value for every coefficient that a lens may have; of a shape that sees all rays below.
VALUES = {
    **{"k1": -0.21, "k2": 0.05, "p1": 1e-3, "p2": -2e-3, "k3": 0.01, "k4": 0.03, "k5": -0.02},
    **{"k6": 0.004, "s1": 1e-3, "s2": -5e-4, "s3": 7e-4, "s4": 2e-4},
    **{"lambda": -0.15, "alpha": 0.6, "beta": 1.1, "xi": 0.3},
}
LENSES = {
    "radial 0": lens_named("radial", order=0, tangential=False),
    "radial 1": lens_named("radial", order=1, tangential=False),
    "radial 2": lens_named("radial", order=2, tangential=False),
    "radial 3": lens_named("radial", order=3, tangential=False),
    "radial 4": lens_named("radial", order=4, tangential=False),
    "opencv4": lens_named("opencv4"),
    "opencv5": lens_named("opencv5"),
    "rational 1": lens_named("rational", order=1),
    "opencv8": lens_named("opencv8"),
    "thin-prism": lens_named("thin-prism"),
    "opencv12": lens_named("opencv12"),
    "fisheye 0": lens_named("fisheye", order=0),
    "fisheye 2": lens_named("fisheye", order=2),
    "fisheye 4": lens_named("fisheye", order=4),
    "fisheye 5": lens_named("fisheye", order=5),
    "division": lens_named("division"),
    "eucm": lens_named("eucm"),
    "double-sphere": lens_named("double-sphere"),
}
HELD = {
    "opencv": {*LENSES} - {"radial 4", "fisheye 5", "division", "eucm", "double-sphere"},
    "ros": {*LENSES}
    - {"radial 4", "thin-prism", "opencv12", "fisheye 5", "division", "eucm", "double-sphere"},
    "kalibr": {
        *("radial 0", "radial 1", "radial 2", "opencv4", "fisheye 0", "fisheye 2", "fisheye 4"),
        *("eucm", "double-sphere"),
    },
    "mrcal": {name for name in LENSES if "radial" in name} - {"radial 4"}
    | {"opencv4", "opencv5", "rational 1", "opencv8", "thin-prism", "opencv12"},
    "colmap": {*LENSES} - {"radial 4", "thin-prism", "opencv12", "fisheye 5", "double-sphere"},
}
CASES = [(form, name) for form in FORMATS for name in LENSES if name in HELD[form]]


def camera(lens: Lens) -> FittedCamera:
    k = np.array([VALUES[name] for name in lens.names])
    spread = np.random.default_rng(1).normal(size=(20, 4 + len(k)))
    return FittedCamera.from_arrays(
        lens, INTRINSICS, k, SIZE, covariance=np.cov(spread.T), model="a test"
    )


def rays() -> np.ndarray:
    x, y = np.meshgrid(np.linspace(-0.6, 0.6, 7), np.linspace(-0.45, 0.45, 5))
    return np.column_stack([x.ravel(), y.ravel(), np.ones(x.size)])


def expected(lens: Lens) -> np.ndarray:
    k = np.array([VALUES[name] for name in lens.names])
    assert lens.seen(rays(), k).all()
    return Camera(lens).pixels(INTRINSICS, k, rays())


def by_opencv(matrix: np.ndarray, k: np.ndarray, fisheye: bool) -> np.ndarray:
    zero, points = np.zeros(3), rays().reshape(1, -1, 3)
    if fisheye:
        return cv2.fisheye.projectPoints(points, zero, zero, matrix, k)[0].reshape(-1, 2)
    return cv2.projectPoints(points, zero, zero, matrix, k)[0].reshape(-1, 2)


def as_matrix(values: list[float]) -> np.ndarray:
    fx, fy, cx, cy = values
    return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])


def opencv_reads(path: Path) -> np.ndarray:
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    assert storage.getNode("image_width").real() == SIZE[0]
    assert storage.getNode("image_height").real() == SIZE[1]
    matrix, k = (storage.getNode(n).mat() for n in ("camera_matrix", "distortion_coefficients"))
    return by_opencv(matrix, k, bool(storage.getNode("fisheye_model").real()))


def ros_reads(path: Path) -> np.ndarray:
    found = yaml.safe_load(path.read_text())
    assert (found["image_width"], found["image_height"]) == SIZE
    shaped = {
        name: np.array(found[name]["data"]).reshape(found[name]["rows"], found[name]["cols"])
        for name in ("camera_matrix", "rectification_matrix", "projection_matrix")
    }
    np.testing.assert_array_equal(shaped["projection_matrix"][:, :3], shaped["camera_matrix"])
    np.testing.assert_array_equal(shaped["rectification_matrix"], np.eye(3))
    k, model = np.array(found["distortion_coefficients"]["data"]), found["distortion_model"]
    assert len(k) == {"plumb_bob": 5, "rational_polynomial": 8, "equidistant": 4}[model]
    return by_opencv(shaped["camera_matrix"], k, model == "equidistant")


def kalibr_reads(path: Path) -> np.ndarray:
    found = yaml.safe_load(path.read_text())["cam0"]
    assert tuple(found["resolution"]) == SIZE
    shape, values = found["intrinsics"][:-4], found["intrinsics"][-4:]
    if found["camera_model"] == "pinhole":
        k, model = np.array(found["distortion_coeffs"]), found["distortion_model"]
        assert len(k) == {"radtan": 4, "equidistant": 4, "none": 0}[model]
        return by_opencv(as_matrix(values), k, model == "equidistant")
    x, y, z = rays().T
    if found["camera_model"] == "eucm":  # Khomutenko 2016, eq. 6
        alpha, beta = shape
        depth = alpha * np.sqrt(beta * (x**2 + y**2) + z**2) + (1 - alpha) * z
    else:  # Usenko 2018, eq. 40-42
        xi, alpha = shape
        assert found["camera_model"] == "ds"
        further = xi * np.sqrt(x**2 + y**2 + z**2) + z
        depth = alpha * np.sqrt(x**2 + y**2 + further**2) + (1 - alpha) * further
    return np.column_stack([x / depth, y / depth]) * values[:2] + values[2:]


def mrcal_reads(path: Path) -> np.ndarray:
    found = ast.literal_eval(path.read_text())
    assert tuple(found["imagersize"]) == SIZE
    assert found["rt_cam_ref"] == found["extrinsics"] == [0] * 6
    values, k = found["intrinsics"][:4], np.array(found["intrinsics"][4:], dtype=float)
    lengths = {f"LENSMODEL_OPENCV{n}": n for n in (4, 5, 8, 12)} | {"LENSMODEL_PINHOLE": 0}
    assert len(k) == lengths[found["lensmodel"]]
    return by_opencv(as_matrix(values), k if len(k) else np.zeros(4), False)


def colmap_reads(path: Path) -> np.ndarray:
    folder = path.parent
    path.rename(folder / "cameras.txt")
    for name in ("images.txt", "points3D.txt", "frames.txt", "rigs.txt"):
        (folder / name).write_text("")
    reconstruction = pycolmap.Reconstruction()
    reconstruction.read_text(str(folder))
    (found,) = reconstruction.cameras.values()
    assert (found.width, found.height) == SIZE
    return np.asarray(found.img_from_cam(rays())) - 0.5


READERS = {
    **{"opencv": opencv_reads, "ros": ros_reads, "kalibr": kalibr_reads},
    **{"mrcal": mrcal_reads, "colmap": colmap_reads},
}


# Where the reader tells a format by the file's name.
SUFFIXES = {"opencv": ".yml"}


@pytest.mark.parametrize(("form", "name"), CASES)
def test_the_tool_projects_where_the_lens_does(tmp_path: Path, form: str, name: str) -> None:
    path = tmp_path / f"camera{SUFFIXES.get(form, '')}"
    bc.save_camera(camera(LENSES[name]), path, form)
    np.testing.assert_allclose(READERS[form](path), expected(LENSES[name]), rtol=0, atol=1e-9)


@pytest.mark.parametrize("form", FORMATS)
def test_a_lens_that_a_format_lacks_is_refused(form: str) -> None:
    for name in sorted({*LENSES} - HELD[form]):
        with pytest.raises(bc.InputError, match=f"{FORMATS[form].NAME} has no .* lens with"):
            camera_text(camera(LENSES[name]), form)


def test_a_refusal_names_the_formats_that_have_it() -> None:
    with pytest.raises(bc.InputError, match=r"has no eucm lens.*write it for kalibr, colmap"):
        camera_text(camera(LENSES["eucm"]), "opencv")
    with pytest.raises(bc.InputError, match="no format here has it"):
        camera_text(camera(LENSES["radial 4"]), "mrcal")
    with pytest.raises(bc.InputError, match="no format is called 'ply'; there are opencv, ros"):
        camera_text(camera(LENSES["eucm"]), "ply")


def test_covariance_within_opencvs_file(tmp_path: Path) -> None:
    given = camera(LENSES["opencv4"])
    bc.save_camera(given, tmp_path / "c.yml")
    storage = cv2.FileStorage(str(tmp_path / "c.yml"), cv2.FILE_STORAGE_READ)
    np.testing.assert_array_equal(storage.getNode("covariance").mat(), given.covariance)
    node = storage.getNode("parameters")
    names = tuple(node.at(i).string() for i in range(node.size()))
    assert names == ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2")
    assert list(tmp_path.iterdir()) == [tmp_path / "c.yml"]


@pytest.mark.parametrize("form", [form for form in FORMATS if form != "opencv"])
def test_covariance_beside_the_others(tmp_path: Path, form: str) -> None:
    given = camera(LENSES["radial 2"])
    bc.save_camera(given, tmp_path / "c", form)
    with (tmp_path / f"c{BESIDE}").open() as stream:
        head, *rows = csv.reader(stream)
    assert head == ["", "fx", "fy", "cx", "cy", "k1", "k2"]
    assert [row[0] for row in rows] == head[1:]
    read = np.array([[float(v) for v in row[1:]] for row in rows])
    np.testing.assert_array_equal(read, given.covariance)
    with pytest.raises(OutputError, match="exists"):
        bc.save_camera(given, tmp_path / "c", form)
    (tmp_path / "c").unlink()
    with pytest.raises(OutputError, match="exists"):  # of the covariance alone: nothing is written
        bc.save_camera(given, tmp_path / "c", form)
    assert not (tmp_path / "c").exists()
    bc.save_camera(given, tmp_path / "c", form, force=True)


def test_a_camera_that_is_not_sound_says_so() -> None:
    k = np.array([0.1, 0.0])
    lens = lens_named("radial", order=2, tangential=False)
    given = FittedCamera.from_arrays(lens, INTRINSICS, k, SIZE, sound=False)
    for form in FORMATS:
        assert "NOT SOUND" in camera_text(given, form)
        assert camera_text(given, form).isascii()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"intrinsics": [1.0, 2, 3]}, "has fx, fy, cx, cy and 2 coefficients"),
        ({"coefficients": [0.1]}, "has fx, fy, cx, cy and 2 coefficients"),
        ({"coefficients": [0.1, np.nan]}, "must be finite"),
        ({"intrinsics": [-1.0, 2, 3, 4]}, "must be positive"),
        ({"size": (0, 480)}, "must be positive"),
        ({"covariance": np.eye(3)}, "covariance must be 6 by 6"),
        ({"covariance": np.eye(1), "names": ["k9"]}, "parameters of a radial lens are fx"),
    ],
)
def test_numbers_that_are_no_camera(change: dict[str, object], message: str) -> None:
    given = {
        **{"intrinsics": INTRINSICS, "coefficients": [0.1, 0.0], "size": SIZE},
        **change,
    }
    lens = lens_named("radial", order=2, tangential=False)
    with pytest.raises(bc.InputError, match=message):
        FittedCamera.from_arrays(lens, **given)


def test_opencvs_order_is_that_of_its_documentation() -> None:
    assert SLOTS == ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4")
