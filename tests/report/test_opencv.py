"""A pinhole written for OpenCV, judged by OpenCV itself."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

import bayescal as bc
from bayescal.cli import main
from bayescal.density.pinholes.fit import fit_pinhole
from bayescal.errors import InputError
from bayescal.noise.level import NoiseLevel
from tests.helpers.cameras import problem, turned_points

FLIP = np.array([1.0, -1.0, 1.0])


def read(path):
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    names = ("camera_matrix", "distortion_coefficients", "rotation_vector", "translation_vector")
    return storage, [storage.getNode(name).mat() for name in names]


def middle(found):
    """The camera at the mean of the sampled coordinates, and its geometry."""
    posterior = found.best.posterior
    model = posterior.model
    theta = model.coordinates(posterior.full.reshape(-1, posterior.full.shape[2]))
    free = model.geometry.free(theta).mean(axis=0, keepdims=True)
    return model.geometry, model.geometry.full(free)


@pytest.mark.parametrize("order", [0, 2, 3])
@pytest.mark.parametrize("position", ["free", "stated"])
def test_opencv_projects_where_the_camera_does(tmp_path, order, position):
    """Rows count from the top again: the points file's own pixels, with y negated."""
    points = bc.thesis()
    found = bc.fit_family(points, "pinhole", (order,), position=position, ess=100)
    bc.save_opencv(found, tmp_path / "camera.yml")
    storage, (matrix, distortion, turn, shift) = read(tmp_path / "camera.yml")
    assert storage.getNode("world_points").string().startswith("y negated")
    assert storage.getNode("image_width").real() == 1920
    assert storage.getNode("draws_converged").real() == 1
    projected, _ = cv2.projectPoints(points.world * FLIP, turn, shift, matrix, distortion)
    geometry, theta = middle(found)
    r, c = geometry.project(theta)[0][0]
    np.testing.assert_allclose(projected[:, 0], np.column_stack([r, 1080 - c]), atol=1e-6)
    if position == "stated":
        place = -cv2.Rodrigues(turn)[0].T @ shift[:, 0] * FLIP
        np.testing.assert_allclose(place, points.setup.position, atol=1e-9)
    residual = projected[:, 0] - points.pixels
    assert np.sqrt((residual**2).mean()) < 10  # px: it is a camera of these points


def test_without_a_flip_the_world_stays(tmp_path):
    points = turned_points(0.06)
    found = bc.fit_family(points, "pinhole", (1,), ess=100)
    bc.save_opencv(found, tmp_path / "camera.yml")
    storage, (matrix, distortion, turn, shift) = read(tmp_path / "camera.yml")
    assert storage.getNode("world_points").string() == "as in the points file"
    projected, _ = cv2.projectPoints(points.world, turn, shift, matrix, distortion)
    geometry, theta = middle(found)
    np.testing.assert_allclose(projected[:, 0], geometry.project(theta)[0][0].T, atol=1e-6)
    # Its rotation and position, from the reported ones by the textbook: t = -R C.
    rotation = cv2.Rodrigues(turn)[0]
    np.testing.assert_allclose(-rotation.T @ shift[:, 0], geometry.position(theta)[0], rtol=1e-9)


def test_a_position_known_well_is_exported_there():
    points = bc.thesis()
    camera = replace(points.setup.camera, position_sd=(1e-3, 1e-3, 1e-3))
    points = replace(points, setup=replace(points.setup, camera=camera))
    found = bc.opencv_camera(bc.fit_family(points, "pinhole", (1,), ess=100))
    place = -cv2.Rodrigues(found.rotation)[0].T @ found.translation * FLIP
    np.testing.assert_allclose(place, points.setup.position, atol=0.01)  # prior sds: ten


def test_covariance_is_that_of_the_draws():
    found = bc.fit_family(turned_points(0.06), "pinhole", (1,), ess=1000)
    camera = bc.opencv_camera(found)
    assert camera.covariance.shape == (11, 11)
    posterior = found.best.posterior
    sd = dict(zip(camera.names, np.sqrt(np.diag(camera.covariance)), strict=True))
    for name, ours in (("fx", "focal_r"), ("fy", "focal_c"), ("cx", "centre_r"), ("k1", "k_1")):
        assert sd[name] == pytest.approx(posterior[ours].sd, rel=1e-3)


def test_least_squares_are_those_of_calibrate_camera():
    """OpenCV minimises the squared distance of all pixels: sigma known and equal here."""
    points = turned_points(0.06)
    geometry, prior, data = problem(points, 1, levels=(NoiseLevel.known(0.06),) * 2)
    fit = fit_pinhole(points, geometry, prior, data)
    theta = geometry.full(fit.free[None])
    guess = np.array([[3000.0, 0, 288], [0, 3000, 192], [0, 0, 1]])
    flags = cv2.CALIB_USE_INTRINSIC_GUESS | cv2.CALIB_ZERO_TANGENT_DIST
    flags |= cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_K3
    stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 1000, 1e-15)
    _, matrix, distortion, _, _ = cv2.calibrateCamera(
        [points.world.astype(np.float32)], [points.pixels.astype(np.float32)], (576, 384),
        guess, np.zeros(5), flags=flags, criteria=stop,
    )  # fmt: skip
    sd = np.sqrt(np.diag(fit.covariance))
    theirs = np.array([*np.log(matrix[[0, 1], [0, 1]]), matrix[0, 2], matrix[1, 2]])
    # Single-precision input: a few hundredths of a standard deviation.
    assert (np.abs(theirs - theta[0, :4]) < 0.05 * sd[:4]).all()
    assert distortion.ravel()[0] == pytest.approx(geometry.coefficients(theta)[0, 0], rel=0.02)


@pytest.mark.parametrize(
    ("options", "match"),
    [
        (["--order-r", "1", "--order-c", "1"], "--opencv belongs to a pinhole"),
        (["--family", "bivariate", "--order", "1"], "a pinhole, not bivariate"),
        (["--family", "pinhole", "--order", "4"], "order 0 to 3"),
        (["--family", "pinhole", "--order", "1", "--opencv", "-"], "name a file"),
        (["--family", "pinhole", "--order", "1", "--radial", "all"], "--radial even"),
    ],
)
def test_what_opencv_has_no_words_for_is_refused(options, match, tmp_path, capsys):
    place = tmp_path / "camera.yml"
    assert main(["fit", "--opencv", str(place), *options]) == 2
    assert match in capsys.readouterr().err
    assert not place.exists()


def test_one_file_for_two_outputs_is_refused(tmp_path, capsys):
    place = str(tmp_path / "camera.yml")
    fit = ["fit", "--family", "pinhole", "--order", "0", "--opencv", place, "--json", place]
    assert main([*fit, "--force"]) == 2
    assert "name the same file" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_nothing_is_replaced_unasked(tmp_path, capsys):
    place = tmp_path / "camera.yml"
    place.write_text("mine")
    fit = ["fit", "--family", "pinhole", "--order", "0", "--ess", "100", "--opencv", str(place)]
    assert main(fit) == 2
    assert "exists" in capsys.readouterr().err
    assert place.read_text() == "mine"
    assert main([*fit, "--force"]) == 0
    assert read(place)[1][0].shape == (3, 3)


def test_a_comparison_without_a_pinhole_in_front_is_refused():
    found = bc.compare_families(bc.thesis(), ["separable"], [1], ess=100)
    with pytest.raises(InputError, match="a pinhole, not separable"):
        bc.opencv_camera(found)
    pinhole = bc.fit_family(bc.thesis(), "pinhole", (1,), ess=100)
    wrong = replace(pinhole, request=replace(pinhole.request, radial="all"))
    with pytest.raises(InputError, match="even powers"):
        bc.opencv_camera(wrong)
