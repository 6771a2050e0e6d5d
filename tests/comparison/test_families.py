"""Models of the joint data on one scale: probabilities, the verdict, weak combinations."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2 as chi2_distribution

import bayescal as bc
from bayescal.comparison.criteria import Criteria
from bayescal.comparison.families import FamilyRequest, JointModel, ModelName
from bayescal.comparison.family_verdict import judge_families, model_probabilities
from bayescal.comparison.weak import weak_combinations
from bayescal.errors import InputError
from bayescal.families.analysis import compare_joint
from bayescal.families.caveats import family_caveats
from bayescal.inference.arviz_bridge import psis_loo
from bayescal.models.camera_prior import position_prior
from bayescal.points.camera import StatedCamera
from bayescal.report.families import families_view, joint_fit_view
from bayescal.report.render import render
from bayescal.settings import Settings
from bayescal.sources import Computed
from tests.cameras import TURNED, turned_points


def joint(family, orders, position, evidence):
    name = ModelName(family, orders, position)
    return JointModel(name, Criteria(5), evidence, 0.01, None, np.zeros(3))


def test_a_family_gains_nothing_by_offering_more_orders():
    """Equal evidences: half each, whatever the number of models."""
    models = [joint("separable", (k, m), "stated", -5.0) for k in (1, 2) for m in (1, 2)]
    models += [joint("separable", (1, 1), "free", -5.0), joint("pinhole", (0,), "free", -5.0)]
    chances = model_probabilities(models)
    assert chances == pytest.approx([1 / 16] * 4 + [1 / 4, 1 / 2])


def test_verdict_sums_families_and_positions():
    models = [joint("pinhole", (1,), "free", -1.0), joint("separable", (4, 1), "stated", -9.0)]
    verdict = judge_families(models, model_probabilities(models), ["a caveat"])
    assert verdict.best == models[0].name
    assert verdict.decided
    assert verdict.log_bayes_factor == pytest.approx(8.0)
    assert verdict.families["pinhole"] == pytest.approx(1 / (1 + np.exp(-8)))
    assert verdict.positions["stated"] == pytest.approx(1 / (1 + np.exp(8)))
    assert "2 ln B of pinhole against separable = 16.0, very strong" in verdict.text
    assert "free camera position" not in verdict.text  # it is the family under another name


def test_families_are_judged_by_all_of_their_models():
    """The best of nine pairs leads the only pinhole, and the nine together do not."""
    pairs = [(k, m) for k in (1, 2, 3) for m in (1, 2, 3)]
    models = [joint("separable", pairs[0], "stated", -5.0)]
    models += [joint("pinhole", (0,), "free", -6.0)]
    models += [joint("separable", pair, "stated", -50.0) for pair in pairs[1:]]
    chances = model_probabilities(models)
    order = sorted(range(len(models)), key=lambda i: -chances[i])
    verdict = judge_families([models[i] for i in order], [chances[i] for i in order], [])
    assert verdict.families["pinhole"] == pytest.approx(1 / (1 + np.e / 9))
    factor = 2 * (np.log(9) - 1)
    assert f"2 ln B of pinhole against separable = {factor:.1f}, positive" in verdict.text


def test_both_positions_of_a_family_are_summed():
    models = [joint("separable", (1, 1), "free", -1.0), joint("separable", (1, 1), "stated", -9.0)]
    verdict = judge_families(models, model_probabilities(models), [])
    assert "free camera position has >99.9%" in verdict.text


def test_an_evidence_from_poor_weights_is_not_sound():
    """Though nothing was sampled, and so no chain can have failed."""
    poor = replace(joint("separable", (4, 1), "free", -1.0), doubts=("too few draws",))
    assert not poor.sound
    assert poor.warnings == ("too few draws",)
    assert joint("separable", (4, 1), "free", -1.0).sound


def test_a_default_prior_of_the_position_is_said_to_matter(thesis_families):
    """Only where it decides anything: with both treatments compared, and none stated."""
    caveats = thesis_families.verdict.caveats
    assert any("position depends on its prior's sd" in c and "2.1 nat" in c for c in caveats)


def test_a_default_prior_of_the_orientation_is_said_to_matter(thesis_families):
    """Where pinholes have rivals and may lose; what a stated one costs is for its user to know."""
    found = thesis_families
    assert 0.001 < found.verdict.families["pinhole"] < 0.999
    assert any("orientation's prior" in caveat for caveat in found.verdict.caveats)
    camera = replace(found.points.setup.camera, orientation_sd=(30.0, 30.0, 30.0))
    stated = replace(found.points, setup=replace(found.points.setup, camera=camera))
    caveats = family_caveats(stated, found.models, found.probabilities)
    assert not any("orientation's prior" in caveat for caveat in caveats)


def test_a_camera_far_from_where_its_priors_expect_it_is_said():
    """The orientation stated to a degree is 7 degrees off, and the focal length twice too long."""
    points = turned_points(0.06)
    camera = StatedCamera(
        position_sd=(50.0, 50.0, 50.0), orientation=(37.0, 0.0, 0.0),
        orientation_sd=(1.0, 1.0, 1.0), focal=6000.0, focal_log_sd=0.1,
    )  # fmt: skip
    off = replace(points, setup=replace(points.setup, camera=camera))
    said = [c for c in bc.fit_family(off, "pinhole", (1,), ess=400).verdict.caveats if "sds" in c]
    assert any(c.startswith("the rotation found is ") for c in said)
    assert any(c.startswith("the focal length found is ") for c in said)
    right = bc.fit_family(points, "pinhole", (1,), ess=400).verdict.caveats
    assert not any("prior and data disagree" in caveat for caveat in right)


def test_a_narrow_prior_that_agrees_with_the_points_is_no_disagreement():
    """The likelihood alone is unsure of the position by more than that prior."""
    points = turned_points(0.06)
    true = replace(points.setup, position=TURNED["position"])
    camera = replace(true.camera, position_sd=(1e-4, 1e-4, 1e-4))
    points = replace(points, setup=replace(true, camera=camera))
    for family, orders in (("pinhole", (1,)), ("separable", (1, 1))):
        found = bc.fit_family(points, family, orders, position="free", ess=100)
        said = any("position found" in caveat for caveat in found.verdict.caveats)
        assert said == (family == "separable"), "which is far from looking along z"


def test_a_sigma_at_the_bound_of_its_prior_is_said():
    points = bc.thesis()
    far = replace(points, pixels=points.pixels + np.array([1e6, 0]))
    found = bc.fit_family(far, "pinhole", (0,), ess=100)
    assert any("lies at its bound, 1000 px" in caveat for caveat in found.verdict.caveats)
    plain = bc.fit_family(points, "pinhole", (0,), ess=100)
    assert not any("its bound" in caveat for caveat in plain.verdict.caveats)


def test_weak_combinations_of_a_known_matrix():
    """Two of three move as one (correlation 0.99); without correlations nothing is said."""
    matrix = np.array([[1, -0.99, 0], [-0.99, 1, 0], [0, 0, 1.0]])
    ((names, shares),) = weak_combinations(("a", "b", "c"), matrix)
    assert set(names) == {"a", "b"}
    assert shares == pytest.approx((np.sqrt(0.5), -np.sqrt(0.5)))
    assert weak_combinations(("a", "b", "c"), np.eye(3)) == ()


@pytest.fixture(scope="module")
def thesis_families():
    return bc.compare_families(
        bc.thesis(), ["separable", "bivariate", "pinhole"], [1, 4], radial_orders=[0, 1], ess=400
    )


def test_at_the_stated_position_joint_models_are_products_of_axes(
    thesis_families, thesis_comparison
):
    """Evidence, BIC and AIC of a pair are the sums over its axes (those of `compare`)."""
    r, c = (thesis_comparison.axes[a] for a in "rc")
    for k in (1, 4):
        for m in (1, 4):
            pair = thesis_families[f"separable ({k}, {m}), position stated"]
            one, other, joint_ones = r[k].criteria, c[m].criteria, pair.criteria
            total = r[k].log_evidence + c[m].log_evidence
            assert pair.log_evidence == pytest.approx(total)
            assert joint_ones.bic == pytest.approx(one.bic + other.bic)
            assert joint_ones.aic == pytest.approx(one.aic + other.aic)
            assert joint_ones.n_parameters == one.n_parameters + other.n_parameters


@pytest.mark.parametrize("family", ["separable", "bivariate", "pinhole"])
def test_an_axis_fitted_exactly_leaves_no_criteria(family):
    """Its residuals are rounding, which has no likelihood; the evidence has a least sigma."""
    points = bc.thesis()
    flat = replace(points, pixels=points.pixels * [0, 1] + [5, 0])
    found = bc.fit_family(flat, family, (1,), position="free", ess=100)
    assert found.best.criteria == Criteria(found.best.criteria.n_parameters)
    assert np.isfinite(found.best.log_evidence)
    assert "residuals of an axis are rounding" in render(joint_fit_view(found), terminal=False)


def test_chi_squared_of_joint_models_where_sigma_is_known():
    """At the stated position the sum of both axes'; at a free one that of Gauss-Newton's fit."""
    points = bc.thesis()
    found = bc.compare_families(
        points, ["separable", "pinhole"], [1], position=["stated", "free"], radial_orders=[0],
        sigma=3.0, ess=100,
    )  # fmt: skip
    axes = bc.compare(points, [1], sigma=3.0, ess=100, hint=False).axes
    chi2 = sum(axis[1].goodness.chi2 for axis in axes.values())
    stated = found["separable (1, 1), position stated"].goodness
    assert stated.chi2 == pytest.approx(chi2, rel=1e-12)
    assert stated.dof == 2 * 57 - 4
    # -2 ln L is chi-squared and constants, alike for all models.
    for model in found.models:
        constant = 2 * 57 * math.log(2 * math.pi * 9)
        assert model.goodness.chi2 == pytest.approx(
            -2 * model.criteria.log_likelihood - constant, rel=1e-9
        )
        assert model.goodness.p_value == pytest.approx(
            chi2_distribution.sf(model.goodness.chi2, model.goodness.dof)
        )
    assert found["pinhole 0, position free"].goodness.dof == 2 * 57 - 10
    shown = render(families_view(found), terminal=False)
    assert f"{found.best.goodness.chi2:.1f} with {found.best.goodness.dof} dof" in shown
    assert bc.fit_family(points, "separable", (1, 1), ess=100).best.goodness is None


def test_errors_of_world_coordinates_at_a_free_position():
    """They give each pixel a deviation, the same for every model, which is said."""
    points = bc.thesis()
    setup = replace(points.setup, world_sigma=(1.0, 1.0, 2.0))
    camera = replace(setup.camera, position_sd=(1e-6, 1e-6, 1e-6))
    points = replace(points, setup=replace(setup, camera=camera))
    found = bc.compare_families(
        points, ["separable"], [1], position=["stated", "free"], sigma=3.0, ess=100
    )
    stated, free = (found[f"separable (1, 1), position {p}"] for p in ("stated", "free"))
    # Pinned to a micrometre or so: the quadratures differ by a few thousandths of a nat.
    assert free.log_evidence == pytest.approx(stated.log_evidence, abs=0.01)
    assert any("errors of the world coordinates" in note for note in found.notes)


def test_thesis_data_across_families(thesis_families):
    """Joint BIC of the pair at the stated position and of the pinhole, as the design says."""
    pair = thesis_families["separable (4, 1), position stated"]
    pinhole = thesis_families["pinhole 0, position free"]
    assert pair.criteria.bic == pytest.approx(644.1, abs=0.05)
    assert pinhole.criteria.bic == pytest.approx(630.1, abs=0.05)
    assert thesis_families["bivariate 1, position stated"].log_evidence < pair.log_evidence - 30
    assert thesis_families.sound
    assert sum(thesis_families.probabilities) == pytest.approx(1)


@pytest.mark.parametrize("which", ["middling", "heavy"])
@pytest.mark.parametrize(("family", "orders"), [("pinhole", (0,)), ("separable", (4, 1))])
def test_leave_one_out_is_that_of_fits_without_the_point(family, orders, which):
    """PSIS of a middling point, and the refit of one whose weights fail, are the evidences'."""
    points = bc.thesis()
    model = bc.fit_family(points, family, orders, position="free", ess=400).best
    assert model.loo.reliable, "what weights can't say, refits do"
    middling = int(np.argsort(model.loo.pointwise)[len(points) // 2])
    # Among the refitted the least expected: one at the edge would take the basis's domain along.
    worst = min(model.loo.refitted, key=lambda i: model.loo.pointwise[i])
    point = middling if which == "middling" else worst
    assert (point in model.loo.refitted) == (which == "heavy")
    keep = np.arange(len(points)) != point
    rest = replace(
        points,
        world=points.world[keep],
        pixels=points.pixels[keep],
        labels=tuple(label for i, label in enumerate(points.labels) if keep[i]),
        lines=None,
    )
    sd = tuple(position_prior(points).sd.tolist())
    known = replace(points.setup.camera, position_sd=sd)
    rest = replace(rest, setup=replace(rest.setup, camera=known))
    without = bc.fit_family(rest, family, orders, position="free", ess=400)
    # p(t_i | rest) = p(all) / p(rest), from evidences with errors of their own.
    expected = model.log_evidence - without.best.log_evidence
    error = np.hypot(model.log_evidence_error, without.best.log_evidence_error)
    # The centroid, which anchors the coordinates, moves with the point: only they do. A refit's
    # 600 draws leave 0.01 nat.
    assert model.loo.pointwise[point] == pytest.approx(expected, abs=4 * (error + 0.01))


def test_families_under_robust_noise_are_on_one_scale(tmp_path):
    """Light tails give the Gaussian evidences; a run of heavy ones reopens as it was."""
    both = {"position": ["stated", "free"], "ess": 200}
    plain = bc.compare_families(bc.thesis(), ["separable"], [1], **both)
    light = bc.compare_families(bc.thesis(), ["separable"], [1], noise="student-t", nu=1e10, **both)
    for model in plain.models:
        other = light[str(model.name)]
        error = math.hypot(model.log_evidence_error, other.log_evidence_error)
        assert other.log_evidence == pytest.approx(model.log_evidence, abs=4 * error + 5e-3)
        assert other.criteria.bic is None
        assert model.criteria.bic is not None
    heavy = bc.compare_families(bc.thesis(), ["separable"], [1], noise="student-t", **both)
    shown = render(families_view(heavy), terminal=False)
    assert max(len(line) for line in shown.splitlines()) <= 100
    assert "Student-t, nu ~ Gamma" in shown
    assert "above the rounding of whole readings (0.29 px)" in shown
    assert "no AIC and BIC" in shown
    bc.save_run(heavy, tmp_path / "run")
    again = bc.open_run(tmp_path / "run")
    assert [m.log_evidence for m in again.models] == [m.log_evidence for m in heavy.models]
    assert [m.loo.elpd for m in again.models] == [m.loo.elpd for m in heavy.models]


def test_a_turned_camera_rejects_the_polynomials():
    found = bc.compare_families(
        turned_points(0.06), ["separable", "bivariate", "pinhole"], [1, 2], radial_orders=[0, 1],
        ess=400,
    )  # fmt: skip
    assert str(found.best.name) == "pinhole 1, position free"
    assert found.verdict.families["pinhole"] > 1 - 1e-12
    assert found.verdict.decided
    # The only other one within reach is the pinhole without distortion.
    assert found.verdict.log_bayes_factor > 100
    pairs = [m for m in found.models if m.name.family == "separable"]
    assert found.probabilities[-len(pairs) :] == (0, 0, 0, 0), "too small for a double"
    assert pairs == sorted(pairs, key=lambda m: -m.log_evidence)


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"families": ["homography"]}, "family must be separable, bivariate, pinhole"),
        ({"position": ["nowhere"]}, "position must be stated or free"),
        ({"prior": "flat"}, "flat prior has no evidence"),
    ],
)
def test_refusals(options, match):
    with pytest.raises(InputError, match=match):
        bc.compare_families(bc.thesis(), **options)


class Undrawn(Computed):
    """Nothing may be drawn from it."""

    def sampled(self, name, model, compute):  # noqa: ARG002
        raise AssertionError(f"{name} was sampled")

    weighted = sampled


@pytest.mark.parametrize("noise", ["gaussian", "student-t"])
def test_what_can_not_be_fitted_is_refused_before_anything_is_drawn(noise):
    """Though its family comes last: the points lie in one plane, so no pose and focal length."""
    points = bc.thesis()
    flat = replace(points, world=points.world * [1, 1, 0] + [0, 0, 900])
    request = FamilyRequest(("separable", "pinhole"), (1,), ("free",))
    settings = Settings(noise=noise, defend=False)
    with pytest.raises(InputError, match="lie in one plane"):
        compare_joint(flat, request, settings, source=Undrawn())
    with pytest.raises(AssertionError, match="was sampled"):  # negative control
        compare_joint(points, request, settings, source=Undrawn())


def test_a_position_prior_beyond_doubles_is_refused_where_it_is_used():
    points = bc.thesis()
    camera = replace(points.setup.camera, position_sd=(1e-9, 1.0, 1.0))
    points = replace(points, setup=replace(points.setup, camera=camera))
    with pytest.raises(InputError, match=r"lost in rounding.*--position stated"):
        bc.fit_family(points, "separable", (1, 1), position="free")
    assert bc.fit_family(points, "pinhole", (0,), position="stated", ess=100).sound


def test_the_hint_is_given_where_it_is_due():
    """A turned camera: very strongly. A separable camera, and the thesis data: not."""
    turned = turned_points(0.06)
    found = bc.compare(turned, [1, 2], ess=100)
    assert "free camera position" in found.hint
    gain = float(re.search(r"2 ln B about (\d+)", found.hint)[1])
    pinhole = bc.fit_family(turned, "pinhole", (1,), ess=400).best.log_evidence
    stated = sum(axis.chosen.log_evidence for axis in found.axes.values())
    assert gain == pytest.approx(2 * (pinhole - stated), rel=0.01)  # Laplace
    assert bc.compare(turned, [1, 2], ess=100, hint=False).hint is None
    points = bc.thesis()
    assert bc.compare(points, [1, 4], ess=100).hint is None
    away = points.camera_frame()
    w, u = away[:, 0] / away[:, 2], away[:, 1] / away[:, 2]
    exact = np.column_stack([960 + 1100 * w, 540 - 1100 * u])
    noisy = exact + np.random.default_rng(0).normal(0, 2, exact.shape)
    assert bc.compare(replace(points, pixels=noisy), [1, 2], ess=100).hint is None


def test_leave_one_out_is_marked_where_its_weights_fail(thesis_families):
    """The pinhole's own is good; with a heavy tail it is marked, and every difference to it."""
    plain = render(families_view(thesis_families), terminal=False)
    assert all(m.loo.reliable for m in thesis_families.models)
    assert "? marks" not in plain
    best = thesis_families.best
    heavy = replace(best, loo=replace(best.loo, pareto_k=0.8, k_limit=0.7))
    marked = replace(thesis_families, models=(heavy, *thesis_families.models[1:]))
    shown = render(families_view(marked), terminal=False)
    assert max(len(line) for line in shown.splitlines()) <= 100
    assert f" {best.loo.elpd:.1f}? " in shown
    assert "? marks an elpd" in shown
    assert all("? (" in line for line in shown.splitlines() if line.startswith("   bivariate"))


def test_with_the_coefficients_integrated_out_weights_of_a_point_are_lighter():
    """Of noise of one width none is heavy; by single likelihoods half a dozen are."""
    points = bc.thesis()
    away = points.camera_frame()
    exact = 1100 * away[:, :2] / away[:, 2:] * [1, -1] + [960, 540]
    noisy = exact + np.random.default_rng(1).normal(0, 2, exact.shape)
    found = bc.fit_family(
        replace(points, pixels=noisy), "bivariate", (2,), position="free", ess=400
    ).best
    assert found.loo.reliable
    posterior = found.posterior
    draws = posterior.full.reshape(-1, posterior.full.shape[2])[::2]
    lighter = psis_loo(posterior.model.log_left_out(draws).T).pareto_k
    plain = psis_loo(posterior.model.log_likelihood(draws).T).pareto_k
    assert lighter.max() < 0.7
    assert (lighter > 0.4).sum() < (plain > 0.4).sum() / 2
