"""Comparisons across families: on one scale, on real and simulated points, and what they refuse."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2 as chi2_distribution

import bayescal as bc
from bayescal.comparison.criteria.information import Criteria
from bayescal.comparison.families.analysis import compare_joint
from bayescal.comparison.families.request import FamilyRequest
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from bayescal.errors import InputError
from bayescal.report.terminal import render
from bayescal.report.views.families.views import brief, full
from tests.helpers.cameras import turned_points


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


@pytest.mark.parametrize(("family", "order"), [("separable", 1), ("bivariate", 1), ("pinhole", 0)])
def test_an_axis_fitted_exactly_leaves_no_criteria(family, order):
    """Its residuals are rounding, which has no likelihood; the evidence has a least sigma."""
    points = bc.thesis()
    flat = replace(points, pixels=points.pixels * [0, 1] + [5, 0])
    found = bc.fit_family(flat, family, (order,), position="free", ess=100)
    assert found.best.criteria == Criteria(found.best.criteria.n_parameters)
    assert np.isfinite(found.best.log_evidence)
    assert "residuals of an axis are rounding" in render(full(found), terminal=False)


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
    shown = render(brief(found), terminal=False)
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


def test_families_under_robust_noise_are_on_one_scale(tmp_path):
    """Light tails give the Gaussian evidences; a run of heavy ones reopens as it was."""
    both = {"position": ["stated", "free"], "ess": 200}
    plain = bc.compare_families(bc.thesis(), ["separable"], [1], **both)
    light = bc.compare_families(bc.thesis(), ["separable"], [1], noise="student-t", nu=1e10, **both)
    for model in plain.models:
        other = light[str(model.key)]
        error = math.hypot(model.log_evidence_error, other.log_evidence_error)
        assert other.log_evidence == pytest.approx(model.log_evidence, abs=4 * error + 5e-3)
        assert other.criteria.bic is None
        assert model.criteria.bic is not None
    heavy = bc.compare_families(bc.thesis(), ["separable"], [1], noise="student-t", **both)
    shown = render(brief(heavy), terminal=False)
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
    assert str(found.best.key) == "pinhole 1, position free"
    assert found.verdict.families["pinhole"] > 1 - 1e-12
    assert found.verdict.decided
    # The only other one within reach is the pinhole without distortion.
    assert found.verdict.log_bayes_factor > 100
    pairs = [m for m in found.models if m.key.family == "separable"]
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


class Undrawn(Store):
    """Nothing may be drawn from it."""

    def read(self, key, model, *, beside):  # noqa: ARG002
        raise AssertionError(f"{key} was sampled")


@pytest.mark.parametrize("noise", ["gaussian", "student-t"])
def test_what_can_not_be_fitted_is_refused_before_anything_is_drawn(noise):
    """Though its family comes last: the points lie in one plane, so no pose and focal length."""
    points = bc.thesis()
    flat = replace(points, world=points.world * [1, 1, 0] + [0, 0, 900])
    request = FamilyRequest(("separable", "pinhole"), (1,), ("free",))
    settings = Settings(noise=noise, defend=False)
    with pytest.raises(InputError, match="lie in one plane"):
        compare_joint(flat, request, settings, store=Undrawn())
    with pytest.raises(AssertionError, match="was sampled"):  # negative control
        compare_joint(points, request, settings, store=Undrawn())


@pytest.mark.parametrize("family", ["separable", "bivariate", "pinhole"])
def test_a_pixel_far_off_the_image_is_refused_by_every_family(family):
    points = bc.thesis()
    far = replace(points, pixels=points.pixels + np.array([1e6, 0]))
    with pytest.raises(InputError, match="is far outside an image of 1920 px"):
        bc.fit_family(far, family, (1,) if family != "separable" else (1, 1))


def test_a_position_prior_beyond_doubles_is_refused_where_it_is_used():
    points = bc.thesis()
    camera = replace(points.setup.camera, position_sd=(1e-9, 1.0, 1.0))
    points = replace(points, setup=replace(points.setup, camera=camera))
    with pytest.raises(InputError, match=r"lost in rounding.*--position stated"):
        bc.fit_family(points, "separable", (1, 1), position="free")
    assert bc.fit_family(points, "pinhole", (0,), position="stated", ess=100).sound
