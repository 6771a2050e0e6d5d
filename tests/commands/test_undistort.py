"""``bayescal undistort``: straight lines come out straight; what can't be is named."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from bayescal.cameras.camera import Camera
from bayescal.cameras.lenses import lens_named
from bayescal.cli import main
from bayescal.errors import InputError
from bayescal.report.cameras.camera import FittedCamera
from bayescal.report.cameras.read import load_camera
from bayescal.report.cameras.write import save_camera

SIZE = (320, 240)
INTRINSICS = [268.0, 268.0, 171.0, 117.0]
BARREL = [-0.28, 0.12, 8e-4, -5e-4, -0.02]


def camera(name="opencv5", k=BARREL, **options):
    return FittedCamera.from_arrays(lens_named(name, **options), INTRINSICS, k, SIZE)


def photograph(made):
    """What a camera sees of a world that is bright on the right of a slanted line."""
    rows, columns = np.mgrid[0 : SIZE[1], 0 : SIZE[0]].astype(float)
    at = np.column_stack([columns.ravel(), rows.ravel()])
    rays = Camera(made.lens).rays(made.intrinsics, made.coefficients, at).rays
    side = rays[:, 0] / rays[:, 2] - 0.2 * rays[:, 1] / rays[:, 2] - 0.35
    # A ramp over some pixels, so that the line's place is known to a fraction of one.
    grey = 128 + 127 * np.clip(side * 60, -1, 1)
    return grey.reshape(SIZE[1], SIZE[0]).round().astype(np.uint8)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    made = camera()
    save_camera(made, "camera.yml")
    grey = photograph(made)
    cv2.imwrite("line.png", np.dstack([grey, grey // 2, grey // 4]))
    return tmp_path


def columns_of_the_line(grey):
    """Column at which each row passes 128, to a fraction of a pixel."""
    right = (grey > 128).argmax(axis=1)
    rows = np.arange(len(grey))
    low, high = grey[rows, right - 1].astype(float), grey[rows, right].astype(float)
    return right - 1 + (128 - low) / (high - low)


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("field", ["same", "inside", "full", "60"])
def test_a_bent_line_comes_out_straight(field, capsys):
    assert main(["undistort", "camera.yml", "line.png", "--out", "out", "--field", field]) == 0
    image = cv2.imread("out/line.png")
    ideal = load_camera("out/camera.yml")
    assert ideal.lens.names == ()
    fx, fy, cx, cy = ideal.intrinsics
    rows = np.arange(40, 200)
    truth = cx + fx * (0.35 + 0.2 * (rows - cy) / fy)
    found = columns_of_the_line(image[rows, :, 0])
    # Sampled linearly from whole grey levels, of which a pixel holds some 28.
    np.testing.assert_allclose(found, truth, rtol=0, atol=0.15)
    assert np.abs(image[..., 1].astype(int) - image[..., 0] // 2).max() <= 1  # each channel alone
    printed = capsys.readouterr().out
    assert "1 of 1 photograph undistorted in out" in printed
    assert f"fx {fx:.2f}" in printed
    assert ("black: " in printed) == (not (image > 0).any(axis=2).all())
    bent = columns_of_the_line(cv2.imread("line.png")[rows, :, 0])
    assert np.ptp(bent - np.polyval(np.polyfit(rows, bent, 1), rows)) > 1  # px: it was none


def test_photographs_that_are_none_are_named_and_the_rest_undistorted(folder, capsys):
    (folder / "broken.png").write_text("no image")
    cv2.imwrite("small.png", np.zeros((10, 20), np.uint8))
    assert main(["undistort", "camera.yml", "*.png", "--out", "out"]) == 0
    printed = capsys.readouterr().out
    assert "1 of 3 photographs undistorted" in printed
    assert "not used: broken.png: is no image that OpenCV reads" in printed
    assert "not used: small.png: is of 20 by 10 px, the camera of 320 by 240" in printed
    assert sorted(p.name for p in (folder / "out").iterdir()) == ["camera.yml", "line.png"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["line.png", "line.png", "--out", "out"], "null byte"),
        (["none.yml", "line.png", "--out", "out"], "none.yml: there is no such file"),
        (["camera.yml", "none.png", "--out", "out"], "none.png: there is no such file"),
        (["camera.yml", "line.png", "--out", "."], "would replace a photograph"),
        (["camera.yml", "line.png", "--out", "a/b"], "a/b"),
        (["camera.yml", "line.png", "--out", "out", "--field", "wide"], "use same, inside, full"),
        (["camera.yml", "line.png", "--out", "out", "--field", "nan"], "a field of nan degrees"),
        (["camera.yml", "camera.yml", "--out", "out"], "would replace a photograph"),
    ],
)
def test_bad_input_is_one_line_and_nothing_is_written(folder, arguments, words, capsys):
    before = sorted(p.name for p in folder.iterdir())
    assert main(["undistort", *arguments]) == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1
    assert sorted(p.name for p in folder.iterdir()) == before


@pytest.mark.usefixtures("folder")
def test_nothing_is_replaced_unasked(capsys):
    command = ["undistort", "camera.yml", "line.png", "--out", "out"]
    assert main(command) == 0
    assert main(command) == 2
    assert "exists" in capsys.readouterr().err
    assert main([*command, "--force", "--quiet"]) == 0
    assert capsys.readouterr().out == ""


RATIONAL = [8.0, 3.0, 8e-4, -5e-4, 0.2, 8.4, 5.5, 1.0]


@pytest.mark.parametrize("form", ["opencv", "ros"])
@pytest.mark.parametrize(
    "made",
    [
        camera("radial", [], order=0, tangential=False),
        camera("opencv4", BARREL[:4]),
        camera(),
        camera("opencv8", RATIONAL),
        camera("fisheye", [-0.02, 0.003, -0.0015, 0.0002], order=4),
    ],
    ids=lambda made: f"{made.lens.name}-{len(made.coefficients)}",
)
def test_a_camera_that_was_written_is_read_back(tmp_path, made, form):
    save_camera(made, tmp_path / "camera.yml", form)
    back = load_camera(tmp_path / "camera.yml")
    assert back.size == made.size
    np.testing.assert_array_equal(back.intrinsics, made.intrinsics)
    rays = np.random.default_rng(0).uniform([-0.5, -0.5, 1], [0.5, 0.5, 1.5], (50, 3))
    np.testing.assert_allclose(
        back.lens.distort(rays, back.coefficients),
        made.lens.distort(rays, made.coefficients),
        rtol=1e-15,
    )


def test_a_camera_that_opencv_wrote_is_read(tmp_path):
    place = str(tmp_path / "theirs.yml")
    storage = cv2.FileStorage(place, cv2.FILE_STORAGE_WRITE)
    storage.write("image_width", 320)
    storage.write("image_height", 240)
    storage.write("camera_matrix", np.array([[268.5, 0, 171.25], [0, 267, 117], [0, 0, 1]]))
    storage.write("distortion_coefficients", np.array([[-0.28, 1e-7, 8e-4, -5e-4, -0.02]]).T)
    storage.release()
    back = load_camera(place)
    assert back.lens.names == ("k1", "k2", "p1", "p2", "k3")
    assert back.intrinsics.tolist() == [268.5, 267, 171.25, 117]
    assert back.coefficients.tolist() == [-0.28, 1e-7, 8e-4, -5e-4, -0.02]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("camera_matrix", "matrix"), "holds no camera_matrix of nine numbers"),
        (("image_width: 320", "image_width: wide"), "holds no image_width"),
        (("268.0, 0.0, 171.0", "268.0, 5.0, 171.0"), "skewed by 5"),
        (("268.0, 0.0, 171.0", "-268.0, 0.0, 171.0"), "must be positive"),
        (("-0.28", "nan"), "must be finite"),
        (("-0.28", "x"), "distortion_coefficients holds something that is no number"),
        (("-0.28,", "-0.28, 0.1,"), "6 distortion coefficients are no lens known here"),
        (("-0.28", "-0.28, 0, 0, 0, 0, 0, 0, 0, 0, 0.1"), "14 distortion .* tilted sensor"),
        (("fisheye_model: 0", "fisheye_model: 1"), "a fisheye has 4 distortion coefficients"),
        (("fisheye_model: 0", "distortion_model: fov"), "distortion_model fov is none of"),
    ],
)
def test_files_that_are_no_camera_are_refused(tmp_path, change, words):
    place = tmp_path / "camera.yml"
    save_camera(camera(), place)
    place.write_text(place.read_text().replace(*change))
    with pytest.raises(InputError, match=words):
        load_camera(place)


def test_pixels_by_a_calibrated_camera(lens_comparison, tmp_path, capsys):
    """The rows of a table by a camera file are what Python gives; bad rows are named."""
    import bayescal as bc

    bc.keep_camera(bc.camera(lens_comparison), tmp_path / "camera.npz")
    (tmp_path / "pixels.csv").write_text("r,c\n100,200\nx,3\n640,400\n")
    place, table = str(tmp_path / "camera.npz"), str(tmp_path / "pixels.csv")
    assert main(["undistort", place, "--pixels", table, "--out", "-"]) == 0
    printed = capsys.readouterr()
    rows = [line.split(",") for line in printed.out.splitlines()]
    assert rows[0] == ["label", "r", "c", "undistorted_r", "undistorted_c", "note"]
    expected = bc.undistort(place, [[100, 200], [640, 400]])
    np.testing.assert_allclose(np.array([r[3:5] for r in rows[1:]], dtype=float), expected)
    assert [row[5] for row in rows[1:]] == ["", "outside the image"]  # 640 px have centres to 639
    assert "pixels.csv:3: r: 'x'" in printed.err
    assert main(["undistort", place, "--pixels", table, "--out", "-", "--strict"]) == 2
    assert main(["undistort", place, "--out", "-"]) == 2
    assert "one of the two" in capsys.readouterr().err


def test_photographs_by_a_calibrated_camera(lens_comparison, tmp_path, capsys):
    import bayescal as bc

    bc.keep_camera(bc.camera(lens_comparison), tmp_path / "camera.npz")
    grey = np.tile(np.arange(640) // 3, (480, 1)).astype(np.uint8)
    cv2.imwrite(str(tmp_path / "ramp.png"), grey)
    out = tmp_path / "out"
    words = ["undistort", str(tmp_path / "camera.npz"), str(tmp_path / "ramp.png")]
    assert main([*words, "--out", str(out), "--field", "inside"]) == 0
    assert "1 of 1 photograph undistorted" in capsys.readouterr().out
    found = bc.undistortion(tmp_path / "camera.npz", field="inside").image(grey)
    np.testing.assert_array_equal(cv2.imread(str(out / "ramp.png"), 0), found)
