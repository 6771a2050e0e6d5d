"""What residuals of joint models say: statistics against refits and simulation, rates, spread."""

from __future__ import annotations

import html
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import pearson3
from scipy.stats import t as student

import bayescal as bc
from bayescal.comparison.adequacy.neighbours import NEAREST, _upper_tail, neighbours
from bayescal.comparison.adequacy.problem import Problem
from bayescal.comparison.adequacy.surface import surface
from bayescal.comparison.families.analysis import compare_joint
from bayescal.comparison.families.linearised import of_pinhole
from bayescal.comparison.families.models import fitted_pinhole, gaussian_pinhole, noise_levels
from bayescal.comparison.families.request import FamilyRequest
from bayescal.comparison.families.residuals import residual_tests
from bayescal.comparison.settings import Settings
from bayescal.noise.level import NoiseLevel
from bayescal.points.groups import groups_of
from bayescal.report.document.families import families_document
from bayescal.report.terminal import render
from bayescal.report.views.families.views import VIEWS
from tests.helpers.cameras import TURNED, pixels, turned_points
from tests.helpers.problems import make_axis


def linear_problem(rng, n=40):
    """Standard normal errors about a line; places over an image."""
    x = rng.uniform(-0.5, 0.5, n)
    data = make_axis(x, rng.normal(size=n))
    place = rng.uniform(0, 1000, (2, n))
    return Problem(data, np.column_stack([np.ones(n), x]), NoiseLevel.inferred()), place


def test_the_surface_is_an_f_test_of_a_refit():
    problem, place = linear_problem(np.random.default_rng(1))
    u, v = (place - 500) / 500
    columns = [u**i * v**j for i in range(4) for j in range(4 - i)]
    both = np.column_stack([problem.design, *columns])
    t = problem.data.t
    less, more = (t - a @ np.linalg.lstsq(a, t, rcond=None)[0] for a in (problem.design, both))
    spare = len(t) - np.linalg.matrix_rank(both)
    gained = np.linalg.matrix_rank(both) - 2
    f = (less @ less - more @ more) / gained / (more @ more / spare)
    found = surface(problem, place)
    assert found.dof == (gained, spare)
    assert found.value == pytest.approx(f, rel=1e-9)


def test_neighbours_have_the_moments_of_simulated_residuals():
    """I by its definition, over errors simulated and projected off the design."""
    problem, place = linear_problem(np.random.default_rng(2))
    n = problem.n
    apart = np.linalg.norm(place[:, :, None] - place[:, None], axis=0)
    np.fill_diagonal(apart, np.inf)
    links = np.zeros((n, n))
    for i, row in enumerate(apart):
        links[i, np.argsort(row)[:NEAREST]] = 1
    errors = np.random.default_rng(3).normal(size=(20000, n))
    e = errors - errors @ problem.q @ problem.q.T
    simulated = n / links.sum() * np.einsum("mi,ij,mj->m", e, links, e) / (e**2).sum(axis=1)
    own = n / links.sum() * problem.e @ links @ problem.e / problem.rss
    found = neighbours(problem, place)
    assert found.value == pytest.approx(own)
    mean, sd = simulated.mean(), simulated.std()
    words = f"{mean:.2f} ± {sd:.2f} expected"
    assert words in found.meaning
    tail = float(np.mean(simulated >= own))
    assert abs(found.p_value - tail) < 4 * np.sqrt(tail * (1 - tail) / 20000) + 0.003


@pytest.mark.parametrize("n", [15, 30])
def test_neighbours_rarely_alarm_by_chance(n):
    """Where Holm asks, at 0.05 / 8: no more often, within 3 standard errors."""
    rng = np.random.default_rng(n)
    x, place = rng.uniform(-0.5, 0.5, n), rng.uniform(0, 1000, (2, n))
    design = np.column_stack([np.ones(n), x])
    level, sets = 0.05 / 8, 1500
    problems = (
        Problem(make_axis(x, rng.normal(size=n)), design, NoiseLevel.inferred())
        for _ in range(sets)
    )
    rate = np.mean([neighbours(problem, place).p_value < level for problem in problems])
    assert rate < level + 3 * np.sqrt(level / sets)


@pytest.mark.parametrize("skewness", [-0.8, -1e-4, 0.3, 1.5])
def test_the_upper_tail_is_pearsons(skewness):
    for z in (-1.5, 0.0, 2.0, 4.0):
        assert _upper_tail(z, skewness) == pytest.approx(pearson3.sf(z, skewness), rel=2e-3)


def block_of(points):
    """The block of a pinhole fitted to points."""
    settings = Settings(defend=False)
    data = noise_levels(points, settings, 1).data
    return residual_tests(
        points,
        of_pinhole(gaussian_pinhole(fitted_pinhole(points, 1, "free", "even", data, settings))),
    )


def test_false_concerns_of_a_block_are_below_five_per_cent():
    """Negative control: the smallest of all p-values, not adjusted for their number."""
    blocks = [block_of(turned_points(0.06, seed)) for seed in range(40)]
    limit = 0.05 + 3 * np.sqrt(0.05 * 0.95 / 40)
    assert np.mean([any(t.concern for t in block) for block in blocks]) < limit
    least = [min(t.p_value for t in block if t.p_value is not None) for block in blocks]
    assert np.mean(np.array(least) < 0.05) > limit


def test_a_tangential_distortion_and_shared_errors_are_found():
    """0.3 px of the square of the other coordinate; 0.2 px that points of a plane share."""
    points = turned_points(0.06)
    bent = points.pixels + 0.3 * ((points.pixels[:, ::-1] - [200, 300]) / [150, 200]) ** 2
    found = {t.name for t in block_of(replace(points, pixels=bent)) if t.concern}
    assert {"surface over the image, r", "surface over the image, c"} <= found
    shift = np.random.default_rng(0).normal(0, 0.2, (5, 2))
    plane = (points.world[:, 2] / 40).astype(int)
    shared = {
        t.name for t in block_of(replace(points, pixels=points.pixels + shift[plane])) if t.concern
    }
    assert "shared errors in groups, r" in shared


def pair(orders=(2, 1), **settings):
    request = FamilyRequest(("separable",), (2,), pairs=(orders,))
    return compare_joint(bc.thesis(), request, Settings(ess=100, **settings))


def test_spread_over_groups_is_the_jackknife_of_refits():
    """Linear models at a known sigma: to first order in the residuals is exact."""
    found, points = pair(sigma=3.0), bc.thesis()
    away = points.camera_frame()
    z = points.world[:, 2]
    out = {}
    for name, i, order in (("alpha", 0, 2), ("beta", 1, 1)):
        x = away[:, i] / away[:, 2]
        t = points.pixel("rc"[i])
        refits = np.array(
            [
                np.polynomial.polynomial.polyfit(x[z != plane], t[z != plane], order)
                for plane in np.unique(z)
            ]
        )
        count = len(refits)
        sd = np.sqrt((count - 1) / count * ((refits - refits.mean(axis=0)) ** 2).sum(axis=0))
        out |= {f"{name}_{j}": value for j, value in enumerate(sd.tolist())}
    assert found.grouped.count == 9
    assert found.grouped.sd == pytest.approx(out, rel=1e-8)


def test_intervals_by_groups_cover_where_planes_share_errors():
    """Six planes, each off in z by 0.5 units: 95 % intervals of the focal length, 40 cameras."""
    x, y, z = np.meshgrid(np.arange(10.0, 210, 40), np.arange(10.0, 250, 60), np.arange(6) * 40.0)
    world = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    setup, settings, covered = turned_points(0.06).setup, Settings(defend=False), []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        true = world + [0, 0, 1] * rng.normal(0, 0.5, 6)[(world[:, 2] / 40).astype(int), None]
        seen = pixels(true, **TURNED) + rng.normal(0, 0.06, (len(world), 2))
        points = bc.Correspondences.from_arrays(world, seen, setup=setup)
        data = noise_levels(points, settings, 1).data
        model = gaussian_pinhole(fitted_pinhole(points, 1, "free", "even", data, settings))
        found = of_pinhole(model)
        spread = found.spread_over(groups_of(points).members)
        plain = np.sqrt(found.reported[0] @ model.fit.covariance @ found.reported[0])
        off = abs(np.exp(model.fit.free[0]) - TURNED["focal"][0])
        covered.append([off < 1.96 * plain, off < student.ppf(0.975, 5) * spread[0]])
    without, by_group = np.mean(covered, axis=0)
    error = 3 * np.sqrt(0.95 * 0.05 / 40)
    assert without < 0.95 - error  # negative control
    assert abs(by_group - 0.95) < error


def test_a_model_alone_is_not_called_decided():
    """Nothing was compared, and what is against it is said."""
    found = pair()
    assert found.verdict.text.startswith("Separable (2, 1), position stated is the only model")
    assert "the noise is not normal" in found.verdict.text
    assert not found.verdict.decided
    assert [t.name for t in found.adequacy if t.concern]


def test_better_orders_beyond_those_compared_withhold_the_word():
    """Separable (4, 1) at a free position beats a pinhole that has 99 % among those compared."""
    found = bc.compare_families(
        bc.thesis(), ["separable", "pinhole"], [1], position=["free"], radial_orders=[0], ess=100
    )
    assert found.verdict.plausible == (found.best.key,)
    assert not found.verdict.decided
    assert "separable (4, 1), position free, which was not compared, would win" in (
        found.verdict.text
    )
    document = families_document(found, "a test")["verdict"]
    shown = " ".join(render(VIEWS.brief(found), terminal=False).split())
    notebook = html.unescape(found._repr_html_())
    for text in (document["text"], *document["caveats"]):  # every outlet says the same
        assert text in shown
        assert text in notebook
    assert document["text"] in repr(found)


def test_a_defence_takes_out_groups():
    """Stated pairs have closed forms: the winner without each plane is that of a refit."""
    request = FamilyRequest(("separable",), (1, 4), pairs=((1, 1), (4, 1)))
    found = compare_joint(bc.thesis(), request, Settings(ess=100, defend=True))
    assert found.best.key.orders == (4, 1)
    (removal,) = found.defence.groups_that_matter
    assert (removal.name, removal.winner) == ("z = 300", "separable (1, 1), position stated")
    by_axis = bc.compare(bc.thesis(), [1, 4], axis="r", defend=True, ess=100)["r"]
    (same,) = by_axis.defence.groups_that_matter
    assert removal.log_bayes_factor == pytest.approx(same.log_bayes_factor, abs=1e-6)
    assert "without group z = 300 (5 points) separable (1, 1)" in found.verdict.text
