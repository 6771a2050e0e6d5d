"""What figures show is what the result says: artists read back against recomputed truth."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.container import BarContainer
from matplotlib.patches import Rectangle
from matplotlib.quiver import Quiver
from numpy.polynomial import Legendre, Polynomial
from scipy.special import fdtrc

import bayescal as bc
from bayescal.comparison.adequacy.problem import Problem
from bayescal.linear.closed_form import exact_posterior
from bayescal.linear.least_squares import factorise, solve
from bayescal.noise.level import NoiseLevel
from bayescal.polynomials.basis import legendre_design
from bayescal.report.figures.comparison.qq import envelope
from bayescal.report.figures.registry import KINDS
from bayescal.report.figures.style import BLUE, PALE, SKY
from bayescal.report.figures.subject import amplitudes
from bayescal.rounding import percent
from tests.helpers.cases import camera_points
from tests.helpers.problems import make_axis, make_model, thesis_axis


@pytest.fixture(scope="module")
def defended():
    """A small comparison with groups, defended."""
    depth = 100.0 + np.repeat(np.arange(6), 6)
    points = camera_points(36, (960.0, 700.0, 4.0), noise=2.0, seed=3, depth=depth)
    return bc.compare(points, [1, 2, 3], axis="r", defend=True, ess=100)


def line(panel, label):
    (found,) = [artist for artist in panel.lines if artist.get_label() == label]
    return found


def polynomial_residuals(x, t, order):
    return t - Polynomial.fit(x, t, order)(x)


def test_verdict_bars_are_the_probabilities(thesis_comparison):
    figure = KINDS["verdict"].draw(thesis_comparison)
    for panel, axis in zip(figure.axes, thesis_comparison.axes.values(), strict=True):
        bars = [patch for patch in panel.patches if isinstance(patch, Rectangle)]
        heights = [bar.get_height() for bar in bars]
        chances = [result.probability for result in axis.orders]
        np.testing.assert_allclose(heights, 100 * np.array(chances), rtol=1e-12)
        for bar, result in zip(bars, axis.orders, strict=True):
            other = SKY if result.order in axis.verdict.plausible else PALE
            wanted = BLUE if result.order == axis.verdict.order else other
            assert to_hex(bar.get_facecolor()) == wanted
        written = [text.get_text().replace("\u202f", "") for text in panel.texts]
        assert written == [percent(chance) for chance in chances]
    described = KINDS["verdict"].alt_text(thesis_comparison)
    for axis in thesis_comparison.axes.values():
        assert all(f"order {r.order} {percent(r.probability)}" in described for r in axis.orders)


def test_joint_cells_are_products(thesis_comparison):
    (panel,) = KINDS["joint"].draw(thesis_comparison).axes
    r, c = (
        np.array([result.probability for result in thesis_comparison.axes[axis].orders])
        for axis in "rc"
    )
    cells = panel.collections[0].get_array()
    np.testing.assert_allclose(cells, r[:, None] * c[None, :], rtol=1e-12)
    (frame,) = panel.patches
    assert (frame.get_x() + 0.5, frame.get_y() + 0.5) == (c.argmax(), r.argmax())


def test_evidence_curves_are_those_of_fixed_tau(thesis_comparison):
    panel, strip = KINDS["evidence"].draw(thesis_comparison, "r").axes
    curves = [artist for artist in panel.lines if artist.get_label().startswith("order")]
    places = [0, 37, 80, 120]
    shown = np.array([curve.get_ydata()[places] for curve in curves])
    tau = curves[0].get_xdata()[places]
    data = thesis_axis("r")
    truth = np.array(
        [
            [exact_posterior(make_model(data, k, tau=t)).log_integral for t in tau]
            for k in range(1, 6)
        ]
    )
    # The reference is the highest of all, which the places need not hold.
    np.testing.assert_allclose(shown - shown[0, 0], truth - truth[0, 0], atol=2e-6)
    assert max(curve.get_ydata().max() for curve in curves) == 0
    assert [text.get_text() for text in strip.texts] == ["5", "4"]
    (shade,) = panel.patches
    assert shade.get_x() == pytest.approx(0.01 / 1920)
    assert shade.get_x() + shade.get_width() == pytest.approx(0.5)


def test_evidence_strip_follows_the_curves(thesis_comparison):
    panel, strip = KINDS["evidence"].draw(thesis_comparison, "c").axes
    curves = {
        int(artist.get_label().split()[1]): artist
        for artist in panel.lines
        if artist.get_label().startswith("order")
    }
    for patch in strip.patches:
        middle = np.sqrt(patch.get_x() * (patch.get_x() + patch.get_width()))
        heights = {
            k: np.interp(np.log(middle), np.log(a.get_xdata()), a.get_ydata())
            for k, a in curves.items()
        }
        winner = max(heights, key=lambda k: heights[k])
        assert to_hex(patch.get_facecolor()) == to_hex(curves[winner].get_color())


def test_loo_marks_are_paired_differences(defended):
    panel = KINDS["loo"].draw(defended, "r").axes[0]
    prediction = defended.axes["r"].defence.prediction
    pointwise = {k: p.loo.pointwise for k, p in prediction.items()}
    best = max(pointwise, key=lambda k: pointwise[k].sum())
    (marks,) = panel.containers
    data_line, _, (bars,) = marks
    gaps = np.array([pointwise[k] - pointwise[best] for k in pointwise])
    np.testing.assert_allclose(np.array(data_line.get_xdata(), float), gaps.sum(axis=1), atol=1e-9)
    halves = [(ends[1, 0] - ends[0, 0]) / 2 for ends in bars.get_segments()]
    errors = np.sqrt(gaps.shape[1]) * gaps.std(axis=1, ddof=1)
    np.testing.assert_allclose(halves, errors, atol=1e-9)
    diamonds = line(panel, "a group left out (points that share a plane z)").get_xdata()
    grouped = np.array([p.group_elpd for p in prediction.values()])
    np.testing.assert_allclose(diamonds, grouped - grouped.max(), atol=1e-9)
    described = KINDS["loo"].alt_text(defended, "r")
    for k, gap, error in zip(pointwise, gaps.sum(axis=1), errors, strict=True):
        words = "best" if k == best else f"{gap:.1f} ± {error:.1f}".replace("-", "\N{MINUS SIGN}")
        assert f"order {k} {words}" in described


def test_bootstrap_bars_are_the_shares(defended):
    (panel,) = KINDS["bootstrap"].draw(defended, "r").axes
    defence = defended.axes["r"].defence
    bars = {c.get_label(): c for c in panel.containers if isinstance(c, BarContainer)}
    truths = {f"wins with {b.unit}s resampled": b.share for b in defence.resampled}
    assert set(bars) == {*truths, "probability with orders beyond"}
    for label, truth in [*truths.items(), ("probability with orders beyond", None)]:
        shares = truth if truth is not None else defence.beyond.probability
        heights = [bar.get_height() for bar in bars[label]]
        np.testing.assert_allclose(heights, [100 * share for share in shares.values()])
        assert sum(heights) == pytest.approx(100)
        centres = [round(bar.get_x() + bar.get_width() / 2) for bar in bars[label]]
        assert centres == list(shares)


@pytest.mark.parametrize(("axis", "order"), [("r", 4), ("c", 1), ("r", 2)])
def test_residuals_are_those_of_least_squares(thesis_comparison, axis, order):
    (panel,) = KINDS["residuals"].draw(thesis_comparison, axis, order).axes
    data = thesis_axis(axis)
    truth = polynomial_residuals(data.x, data.t, order)
    shown = np.concatenate([a.get_xydata() for a in panel.lines if a.get_marker() in ("o", "D")])
    wanted = np.column_stack([data.x, truth])
    np.testing.assert_allclose(shown[np.lexsort(shown.T)], wanted[np.lexsort(wanted.T)], atol=1e-7)
    sigma = np.sqrt((truth**2).sum() / (len(truth) - order - 1))
    (band,) = panel.patches
    assert band.get_height() == pytest.approx(4 * sigma)
    rms = np.sqrt((truth**2).mean())
    described = KINDS["residuals"].alt_text(thesis_comparison, axis, order)
    assert f"root mean square {rms:.2f} px" in described


def test_named_residuals_stand_out(thesis_comparison):
    (panel,) = KINDS["residuals"].draw(thesis_comparison, "c", 1).axes
    assert sorted(text.get_text() for text in panel.texts) == ["16", "19"]


def test_residuals_over_the_other_regressor(thesis_comparison):
    (panel,) = KINDS["other"].draw(thesis_comparison, "r", 4).axes
    world = bc.thesis().world - np.array(bc.thesis().setup.position)
    shown = np.concatenate([a.get_xdata() for a in panel.lines if a.get_marker() in ("o", "D")])
    u, data = world[:, 1] / world[:, 2], thesis_axis("r")
    np.testing.assert_allclose(np.sort(shown), np.sort(u), rtol=1e-12)
    base = np.vander(data.x, 5)
    more = np.column_stack([base, u, u**2, data.x * u])
    rss = [
        float(((data.t - m @ np.linalg.lstsq(m, data.t, rcond=None)[0]) ** 2).sum())
        for m in (base, more)
    ]
    dof = len(u) - more.shape[1]
    p = fdtrc(3, dof, (rss[0] - rss[1]) / 3 / (rss[1] / dof))
    assert f"p = {p:.2g}" in panel.get_title(loc="right")


@pytest.mark.parametrize("from_bottom", [True, False])
def test_image_arrows_point_from_predicted_to_measured(from_bottom):
    points = camera_points(20, noise=3.0, seed=5)
    setup = bc.Setup(width=1920.0, height=1080.0, c_from_bottom=from_bottom)
    points = bc.Correspondences.from_arrays(points.world, points.pixels, setup=setup)
    comparison = bc.compare(points, [1], ess=100)
    (panel,) = KINDS["image"].draw(comparison).axes
    (arrows,) = [a for a in panel.collections if isinstance(a, Quiver)]
    x, y = (points.world[:, i] / points.world[:, 2] for i in (0, 1))
    r, c = points.pixel("r"), points.pixel("c")
    np.testing.assert_allclose(arrows.U, polynomial_residuals(x, r, 1), atol=1e-7)
    upwards = 1 if from_bottom else -1  # of larger c on the page
    np.testing.assert_allclose(arrows.V, upwards * polynomial_residuals(y, c, 1), atol=1e-7)
    np.testing.assert_allclose(np.column_stack([arrows.X, arrows.Y]), np.column_stack([r, c]))
    assert panel.yaxis_inverted() is not from_bottom
    one = KINDS["image"].draw(comparison, "c", 1).axes[0]
    (arrows,) = [a for a in one.collections if isinstance(a, Quiver)]
    assert not arrows.U.any()


def test_qq_points_are_studentised_residuals(thesis_comparison):
    (panel,) = KINDS["qq"].draw(thesis_comparison, "r", 4).axes
    data = thesis_axis("r")
    design = np.vander(data.x, 5)
    e = polynomial_residuals(data.x, data.t, 4)
    leverage = np.diag(design @ np.linalg.pinv(design))
    z = e / np.sqrt((e @ e) / (len(e) - 5) * (1 - leverage))
    np.testing.assert_allclose(line(panel, "point").get_ydata(), np.sort(z), atol=1e-7)


@pytest.mark.parametrize(("n", "order"), [(12, 2), (40, 2)])
def test_qq_envelope_is_left_by_one_set_in_twenty(n, order):
    x = np.linspace(-1, 1, n)
    data = make_axis(x, np.zeros(n) + x)
    problem = Problem.of(data, solve(factorise(data, order), order), NoiseLevel.inferred())
    lower, upper = envelope(problem, np.arange(n), np.random.default_rng(0))
    rng, sets = np.random.default_rng(11), 1500
    q = np.linalg.qr(np.vander(x, order + 1))[0]

    def leaving(errors):
        e = errors - q @ (q.T @ errors)
        free = 1 - (q**2).sum(axis=1)[:, None]
        z = np.sort(e / np.sqrt((e**2).sum(axis=0) / (n - order - 1) * free), axis=0)
        return ((z < lower[:, None]) | (z > upper[:, None])).any(axis=0).mean()

    # Chance in the sets tried and in the 4000 that set the level.
    error = np.sqrt(0.05 * 0.95 * (1 / sets + 1 / 4000))
    assert abs(leaving(rng.standard_normal((n, sets))) - 0.05) < 4 * error
    assert leaving(rng.standard_t(1.5, (n, sets))) > 0.05 + 10 * error


def test_curve_is_the_posterior_less_its_straight_part(thesis_comparison):
    axis = thesis_comparison.axes["r"]
    (panel,) = KINDS["curve"].draw(thesis_comparison, "r", 4).axes
    exact = axis[4].posterior.exact
    monomials = Polynomial(exact.summary[0][:5])
    domain = [axis.data.x.min(), axis.data.x.max()]
    straight = Legendre(monomials.convert(kind=Legendre, domain=domain).coef[:2], domain=domain)
    curve = line(panel, "order 4")
    x = curve.get_xdata()
    np.testing.assert_allclose(curve.get_ydata(), monomials(x) - straight(x), atol=1e-6)
    measured = line(panel, "measured")
    np.testing.assert_allclose(measured.get_ydata(), axis.data.t - straight(axis.data.x), atol=1e-6)
    (band,) = panel.collections
    edge = band.get_paths()[0].vertices
    for place in (0, 40, 80):
        ends = np.sort(edge[np.isclose(edge[:, 0], x[place], atol=1e-9), 1])
        row = legendre_design(np.linspace(-1, 1, 81)[place : place + 1], 4)
        truth = exact.quantiles(row, np.array([0.025, 0.975]))[0] - straight(x[place])
        sd = (truth[1] - truth[0]) / 3.92
        # sqrt(p (1 - p) / n) over the density at the quantile: 0.04 sd at 4000 draws.
        assert abs(ends[0] - truth[0]) < 5 * 0.042 * sd
        assert abs(ends[-1] - truth[1]) < 5 * 0.042 * sd


def test_curve_shows_other_plausible_orders_from_the_same_line(thesis_comparison):
    axis = thesis_comparison.axes["r"]
    (panel,) = KINDS["curve"].draw(thesis_comparison, "r", 4).axes
    four, five = (line(panel, f"order {k}") for k in (4, 5))
    assert 5 in axis.verdict.plausible
    truth = Polynomial(axis[5].posterior.exact.summary[0][:6]) - Polynomial(
        axis[4].posterior.exact.summary[0][:5]
    )
    gap = five.get_ydata() - four.get_ydata()
    np.testing.assert_allclose(gap, truth(four.get_xdata()), atol=1e-6)


def test_amplitudes_of_reported_draws_are_those_sampled(thesis_comparison):
    """What a posterior without closed form is drawn from."""
    axis = thesis_comparison.axes["r"]
    chain = axis[4].posterior.chain
    sampled = chain.theta[..., :5].reshape(-1, 5)
    found = amplitudes(chain.draws[..., :5].reshape(-1, 5), axis.data.domain)
    np.testing.assert_allclose(found, sampled, rtol=1e-9, atol=1e-9 * np.abs(sampled).max())
