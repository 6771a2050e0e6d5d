"""Poses of targets against solvePnP, known poses, and repeated calibrations."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy import linalg, stats

import bayescal as bc
from bayescal.cameras.pose import rotation_vectors, rotations
from bayescal.errors import InputError
from bayescal.prediction.calibrated.lens_member import LensMember
from bayescal.prediction.calibrated.members import Parameters
from bayescal.prediction.picture import Picture
from bayescal.prediction.placing import Placed, sensitivity, settle_poses
from bayescal.prediction.propagating import propagated
from bayescal.prediction.target import locate_target
from tests.helpers.boards import board
from tests.helpers.cases import camera_points

TURN, AT = np.array([0.3, -0.4, 0.2]), np.array([-20.0, 15.0, 420.0])
BODY = np.random.default_rng(3).uniform(-60, 60, (8, 3))


@pytest.fixture(scope="module")
def camera(lens_comparison) -> bc.CalibratedCamera:
    return bc.camera(lens_comparison)


def matrices(camera: bc.CalibratedCamera) -> tuple[np.ndarray, np.ndarray]:
    """OpenCV's camera matrix and distortion of the mean lens."""
    (fx, fy, cx, cy), (k1,) = (v[0] for v in _intrinsics(camera))
    return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]), np.array([k1, 0, 0, 0, 0])


def _intrinsics(camera):
    member = camera.chosen
    assert isinstance(member, LensMember)
    return member.intrinsics(member.parameters.mean[None])


def seen(camera: bc.CalibratedCamera, points, turn=TURN, at=AT) -> np.ndarray:
    return cv2.projectPoints(points, turn, at, *matrices(camera))[0][:, 0]


def refined(camera: bc.CalibratedCamera, points, pixels) -> tuple[np.ndarray, np.ndarray]:
    """What solvePnP's refinement makes of pixels, from the true pose on."""
    stop = (3, 200, 1e-15)
    start = TURN.reshape(3, 1).copy(), AT.reshape(3, 1).copy()
    turn, at = cv2.solvePnPRefineLM(points, pixels, *matrices(camera), *start, stop)
    return turn.ravel(), at.ravel()


def without_lens(camera: bc.CalibratedCamera) -> bc.CalibratedCamera:
    """The same lens, known exactly."""
    member = camera.chosen
    kept = member.parameters
    sure = Parameters(kept.mean, 0 * kept.root, np.tile(kept.mean, (1000, 1)), True)
    return replace(camera, members=(replace(member, parameters=sure),))


@pytest.mark.parametrize("points", [board(), BODY], ids=["board", "body"])
def test_the_pose_is_solve_pnps(camera, points):
    """Truth: cv2.solvePnP, refined as far as it goes, on noisy pixels; exact ones, to rounding."""
    pixels = seen(camera, points) + np.random.default_rng(1).normal(0, 0.2, (len(points), 2))
    found = locate_target(camera, points, pixels, sigma=0.2)
    turn, at = refined(camera, points, pixels)
    np.testing.assert_allclose(seen(camera, points, found.rotation, found.position),
                               seen(camera, points, turn, at), rtol=0, atol=1e-5)  # fmt: skip
    np.testing.assert_allclose(found.position, at, rtol=0, atol=1e-3 * found.sd[:3].min())
    assert found.frame == "camera"
    exact = locate_target(camera, points, seen(camera, points))
    assert np.abs(exact.residuals).max() < 1e-9


def test_noise_alone_is_the_covariance_of_repeated_pictures(camera):
    """Truth: solvePnP of 400 noisy pictures by the lens, fixed; four standard errors."""
    sure, points, rng = without_lens(camera), BODY, np.random.default_rng(2)
    exact = seen(camera, points)
    found = locate_target(sure, points, exact, sigma=0.5)
    repeats = []
    for _ in range(400):
        turn, at = refined(camera, points, exact + rng.normal(0, 0.5, exact.shape))
        repeats.append([*(at - AT), *rotation_vectors(rotations(turn) @ rotations(TURN).T)])
    sd = np.std(repeats, axis=0)
    np.testing.assert_allclose(found.sd, sd, rtol=4 / np.sqrt(800) + 4 / np.sqrt(2000))
    assert (found.parts["coefficients"] < 1e-12).all()


RHO, LENGTH = 1.0, 4 * 25.0  # squares of the board


def test_neighbours_that_share_noise_are_as_sure_as_repeated_pictures(camera):
    """Truth: solvePnP of 300 pictures whose noise is correlated; independent noise is a control."""
    sure, points, rng = without_lens(camera), board(), np.random.default_rng(12)
    member = sure.chosen
    levels = np.tile([0.3, 0.3 * np.sqrt(RHO), LENGTH], (1000, 1))
    noise = replace(member.noise, neighbours=levels)
    sharing = replace(sure, members=(replace(member, noise=noise),))
    exact = seen(camera, points)
    found = locate_target(sharing, points, exact)
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    root = 0.3 * np.linalg.cholesky(np.eye(len(points)) + RHO * np.exp(-apart / LENGTH))
    repeats = []
    for _ in range(300):
        pixels = exact + root @ rng.standard_normal(exact.shape)
        turn, at = refined(camera, points, pixels)
        repeats.append([*(at - AT), *rotation_vectors(rotations(turn) @ rotations(TURN).T)])
    sd = np.std(repeats, axis=0)
    tolerance = 4 / np.sqrt(600) + 4 / np.sqrt(2000)
    np.testing.assert_allclose(found.sd, sd, rtol=tolerance)
    np.testing.assert_allclose(np.sqrt(np.diag(found.linear_covariance)), sd, rtol=4 / np.sqrt(600))
    alone = locate_target(sure, points, exact, sigma=0.3 * np.sqrt(1 + RHO))
    assert (alone.sd < sd / (1 + tolerance)).any()
    stated = locate_target(sharing, points, exact, sigma=0.3 * np.sqrt(1 + RHO))
    np.testing.assert_allclose(stated.linear_covariance, found.linear_covariance)


def test_chi_squared_is_that_of_the_noise_and_the_lens_together(camera):
    """Truth: the same by dense matrices, over what no step of the pose reaches."""
    member, points = camera.chosen, board(4, 3, 60.0)
    levels = np.tile([0.2, 0.1, 80.0], (1000, 1))
    member = replace(member, noise=replace(member.noise, neighbours=levels))
    pixels = seen(camera, points) + np.random.default_rng(5).normal(0, 0.2, (12, 2))
    own = replace(camera, members=(member,))
    found = locate_target(own, points, pixels)
    at = Placed(rotations(found.rotation[None]), found.position[None], np.zeros(1))
    plain = member.in_own_frame()
    scale = Picture(plain.noise).scale
    _, slope, _ = sensitivity(plain, plain.parameters.mean[None], points, pixels[None], scale, at)
    world = points @ found.matrix.T + found.position
    moved, _ = plain.project(plain.parameters.steps, world)
    d = (len(moved) - 1) // 2
    steps = ((moved[1 : 1 + d] - moved[1 + d :]) / 2 / scale).reshape(d, -1).T
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    noise = (0.04 * np.eye(12) + 0.01 * np.exp(-apart / 80.0)) / 0.05
    covariance = np.kron(noise, np.eye(2)) + steps @ steps.T
    free = linalg.null_space(slope[0].T)
    left = free.T @ (found.residuals / scale).ravel()
    expected = left @ np.linalg.solve(free.T @ covariance @ free, left)
    assert found.chi2 == pytest.approx(expected, rel=1e-6)


def test_false_alarms_are_as_rare_as_stated():
    """Truth: cameras drawn from posteriors of 15 points; p is uniform, four standard errors."""
    rng, found = np.random.default_rng(6), []
    camera = bc.camera(bc.fit(camera_points(15, noise=1.0), 2, 1, ess=400))
    member, body = camera.chosen, BODY / 2
    at = Placed(rotations(np.zeros((1, 3))), np.array([[0.0, 0.0, 150.0]]), np.zeros(1))
    world = body @ at.rotation[0].T + at.position[0]
    picture = Picture(member.noise)
    for i in range(0, 1000, 5):
        theta, sigma = member.parameters.draws[i], np.exp(member.noise.log_sigma[i])
        pixels = member.project(theta[None], world)[0][0]
        pixels = pixels + sigma * rng.standard_normal(pixels.shape)
        placed = settle_poses(
            member, member.parameters.mean[None], body, pixels[None], picture.scale, at
        )
        found.append(propagated(member, placed, body, pixels, picture, 0).p_value)
    for level in (0.01, 0.05, 0.5):
        inside = np.mean(np.array(found) < level)
        assert abs(inside - level) < 4 * np.sqrt(level * (1 - level) / len(found)), level


def test_the_p_value_of_robust_noise_is_simulated():
    """Truth: Student-t noise of 10,000 degrees of freedom is normal, whose p has a closed form."""
    camera = bc.camera(bc.fit(camera_points(15, noise=1.0), 2, 1, ess=400))
    member, body = camera.chosen, BODY / 2
    at = Placed(rotations(np.zeros((1, 3))), np.array([[0.0, 0.0, 150.0]]), np.zeros(1))
    pixels = member.project(member.parameters.mean[None], body + at.position[0])[0][0]
    pixels = pixels + 1.2 * np.random.default_rng(2).standard_normal(pixels.shape)
    normal = Picture(member.noise)
    at = settle_poses(member, member.parameters.mean[None], body, pixels[None], normal.scale, at)
    robust = Picture(replace(member.noise, name="student-t", nu=10_000.0))
    assert not robust.gaussian
    p, drawn = (propagated(member, at, body, pixels, n, 0).p_value for n in (normal, robust))
    assert 0.01 < p < 0.99
    # The scale of robust noise is a quantile of simulated residuals: 1 % more beside 1000 draws.
    assert abs(drawn - p) < 4 * np.sqrt(p * (1 - p) / 1000) + 0.02


def test_both_propagations_agree_and_add_up(camera):
    """Truth: linear propagation, to the Monte Carlo error of 1000 draws."""
    found = locate_target(camera, board(), seen(camera, board()))
    linear = np.sqrt(np.diag(found.linear_covariance))
    np.testing.assert_allclose(found.sd, linear, rtol=5 / np.sqrt(2000))
    np.testing.assert_allclose(sum(p**2 for p in found.parts.values()), linear**2)
    # A board of 54 points: the lens, not the pixels, is what is unknown.
    assert (found.parts["coefficients"][:3] > found.parts["noise"][:3]).all()


def test_poses_cover_their_truth(camera):
    """Truth: the pose before lenses drawn from the posterior; sds 30 % too small would show."""
    points, sets, squares = board(4, 3, 60.0), 40, []
    rng, limit = np.random.default_rng(8), stats.chi2.ppf(0.95, 6)
    member = camera.chosen
    for theta in member.parameters.draws[:: 1000 // sets]:
        (fx, fy, cx, cy), (k1,) = (v[0] for v in member.intrinsics(theta[None]))
        lens = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]), np.array([k1, 0, 0, 0, 0])
        turn = rng.normal(0, 0.3, 3)
        at = np.array([*rng.uniform(-40, 40, 2), rng.uniform(350, 500)])
        pixels = cv2.projectPoints(points, turn, at, *lens)[0][:, 0]
        found = locate_target(camera, points, pixels + rng.normal(0, 0.2, pixels.shape))
        spin = rotation_vectors(rotations(turn) @ found.matrix.T)
        away = np.array([*(at - found.position), *spin])
        squares.append(away @ np.linalg.solve(found.linear_covariance, away))
    error = 4 * np.sqrt(0.95 * 0.05 / sets)
    assert abs((np.array(squares) < limit).mean() - 0.95) < error
    assert (np.array(squares) / 0.7**2 < limit).mean() < 0.95 - error  # negative control


def test_a_target_before_polynomials_stands_in_the_world():
    """Truth: a pose in the world of a straight camera, exact pixels; c counted from the bottom."""
    points = camera_points(60, noise=0.1)
    camera = bc.camera(bc.fit(points, 1, 1, ess=100))
    turn, at = np.array([0.2, 0.1, 0.3]), np.array([5.0, -10.0, 200.0])
    world = BODY / 2 @ rotations(turn).T + at
    pixels = bc.predict(camera, world).mean
    found = locate_target(camera, BODY / 2, pixels)
    np.testing.assert_allclose(found.rotation, turn, atol=1e-8)
    np.testing.assert_allclose(found.position, at, atol=1e-6)
    assert found.rms < 1e-8
    assert found.frame == "world"


def test_a_target_of_the_other_hand_is_told(camera):
    """Truth: a body whose mirror image was seen, exactly; a plane is its own mirror image."""
    pixels = seen(camera, BODY * [1.0, 1.0, -1.0])
    found = locate_target(camera, BODY, pixels, sigma=0.1)
    assert found.p_value < 1e-6
    assert found.mirrored < 1e-6
    turned = locate_target(camera, BODY * [1.0, 1.0, -1.0], pixels, sigma=0.1)
    assert turned.mirrored is None
    np.testing.assert_allclose(turned.position, AT, atol=1e-6)
    stretched = locate_target(camera, board() * [1.0, 1.2, 1.0], seen(camera, board()))
    assert stretched.p_value < 1e-6
    assert stretched.mirrored is None


def test_two_poses_of_a_small_square_are_told(camera):
    """Truth: a small square far away looks nearly the same tilted the other way."""
    square = np.array([[-8.0, -8, 0], [8, -8, 0], [8, 8, 0], [-8, 8, 0]])
    turn, at = np.array([0.5, 0.0, 0.0]), np.array([0.0, 0.0, 900.0])
    found = locate_target(camera, square, seen(camera, square, turn, at))
    assert found.second is not None
    assert 1 <= found.odds <= 20
    tilts = sorted(p.matrix[2, 1] for p in (found, found.second))
    assert tilts[0] < 0 < tilts[1]
    assert locate_target(camera, board(), seen(camera, board())).second is None


@pytest.mark.parametrize("seed", range(4))
def test_a_search_that_was_lost_is_no_second_pose(camera, seed):
    """Truth: a pose that fits nearly as well misses the pixels by not much more."""
    square = np.array([[0.0, 0, 0], [25, 0, 0], [0, 25, 0], [25, 25, 0]])
    wrong = np.random.default_rng(seed).normal(0, 2, (4, 2))
    found = locate_target(camera, square, seen(camera, square, at=np.array([9.0, 4, 250])) + wrong)
    assert found.second is None or found.second.rms < 3 * found.rms


def test_a_wrong_target_is_betrayed_by_its_residuals(camera):
    pixels = seen(camera, board())
    found = locate_target(camera, board() * [1.0, 1.05, 1.0], pixels)
    assert found.p_value < 1e-6
    assert locate_target(camera, board(), pixels).p_value > 0.999


def test_what_has_no_pose_is_refused(camera):
    pixels = seen(camera, board())
    for points, at, said in (
        (board()[:3], pixels[:3], "needs 4 points"),
        (board()[:9], pixels[:9], "lie on a line"),
        (board()[:5], pixels[:4], "have 4 pixels"),
    ):
        with pytest.raises(InputError, match=said):
            locate_target(camera, points, at)
    with pytest.raises(InputError, match="sigma must be above 0"):
        locate_target(camera, board(), pixels, sigma=0.0)


def test_a_data_frame_holds_both(camera):
    pandas = pytest.importorskip("pandas")
    rows = np.column_stack([board(), seen(camera, board())])
    frame = pandas.DataFrame(rows, columns=list("xyzrc"))
    found = bc.locate_target(camera, frame)
    again = bc.locate_target(camera, rows[:, :3], rows[:, 3:])
    np.testing.assert_array_equal(found.position, again.position)
    np.testing.assert_array_equal(found.covariance, again.covariance)
    with pytest.raises(InputError, match="pixels are missing"):
        bc.locate_target(camera, board())
