"""An analysis of bad points on disk: reopened it says the same, and what is spoilt is refused."""

from __future__ import annotations

import json
import shutil

import numpy as np
import pytest

import bayescal as bc
from bayescal.errors import InputError
from bayescal.inference.arviz_bridge import parse_netcdf
from bayescal.report.document.outliers import outliers_document
from bayescal.report.run.folder import digest
from tests.helpers.command import here

OPTIONS = ("--axis", "c", "--orders", "1-2", "--ess", "200", "--nu", "4")


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("outliers") / "run"
    done = here("outliers", *OPTIONS, "--out", folder, "--quiet")
    assert done.code == 0, done.err
    return folder


def test_reopened_it_is_the_same(run):
    kept = json.loads((run / "result.json").read_text())
    made = json.loads(json.dumps(outliers_document(bc.open_run(run), "another command")))
    assert made == kept


def test_settings_reach_the_analysis(run):
    kept = json.loads((run / "result.json").read_text())
    assert (kept["settings"]["ess"], kept["settings"]["nu"]) == (200, 4.0)
    direct = bc.outliers(bc.thesis(), [1, 2], axis="c", ess=200, nu=4)
    assert json.loads(json.dumps(outliers_document(direct, "")["axes"])) == kept["axes"]


def test_draws_of_every_sampled_model_are_kept(run):
    names = {path.name for path in (run / "draws").iterdir()}
    assert names == {
        f"c-{noise}-order-{k}.nc" for noise in ("student-t", "outlier-mixture") for k in (1, 2)
    }
    draws = parse_netcdf((run / "draws" / "c-outlier-mixture-order-1.nc").read_bytes())
    assert {"beta_0", "beta_1", "sigma"} <= set(draws.groups["posterior"])


def test_report_shows_the_section(run, tmp_path):
    page = tmp_path / "a.html"
    done = here("report", run, "--out", page)
    assert done.code == 0, done.err
    assert "Order 1 wins" in done.out
    text = page.read_text(encoding="utf-8")
    assert 'id="bad-points"' in text
    assert 'href="#bad-points"' in text
    assert "Points 16 and 19 share" in text


def test_it_is_not_asked_for_what_it_is(run, tmp_path):
    done = here("report", run, "--outliers", "--out", tmp_path / "a.html")
    assert (done.code, done.err.count("\n")) == (2, 1)
    assert "leave out --outliers" in done.err
    assert list(tmp_path.iterdir()) == []


def test_the_library_opens_and_saves_it(run, tmp_path):
    found = bc.open_run(run)
    bc.save_run(found, tmp_path / "again")
    for path in run.rglob("*.*"):
        assert (tmp_path / "again" / path.relative_to(run)).read_bytes() == path.read_bytes()
    with pytest.raises(InputError, match="is no comparison, which alone is defended"):
        bc.open_run(run, defend=True)


def test_other_readers_refuse_it(run, tmp_path):
    done = here("plot", "verdict", run, "--out", tmp_path / "a.png")
    assert (done.code, done.err.count("\n")) == (2, 1)


def _changed(run, folder, change):
    """Copy of the run whose document was changed, and signed anew."""
    shutil.copytree(run, folder)
    document = json.loads((folder / "result.json").read_text())
    change(document)
    (folder / "result.json").write_text(json.dumps(document))
    manifest = json.loads((folder / "run.json").read_text())
    manifest["files"]["result.json"] = digest((folder / "result.json").read_bytes())
    (folder / "run.json").write_text(json.dumps(manifest))
    return folder


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            lambda d: d["axes"]["c"]["points"][0].update(bad_probability=0.5),
            "probability of being bad of point 16",
        ),
        (
            lambda d: d["axes"]["c"]["treatments"][3]["log_evidence"].update({"1": -150.0}),
            "log evidence of order 1 of the outlier mixture of c",
        ),
        (lambda d: d["settings"].update(nu=-1.0), "nu must be"),
        (lambda d: d["settings"].pop("tau"), "settings.tau is missing"),
        (lambda d: d["settings"].update(nu=3.0), "weight of point"),
    ],
)
def test_other_numbers_than_computed_are_refused(run, tmp_path, change, words):
    folder = _changed(run, tmp_path / "changed", change)
    with pytest.raises(InputError, match=words):
        bc.open_run(folder)


def test_a_cut_off_file_is_refused(run, tmp_path):
    folder = tmp_path / "cut"
    shutil.copytree(run, folder)
    draws = folder / "draws" / "c-student-t-order-1.nc"
    draws.write_bytes(draws.read_bytes()[:-10])
    done = here("report", folder, "--out", tmp_path / "a.html")
    assert (done.code, done.err.count("\n")) == (2, 1)
    assert "is not what was written there" in done.err


def test_it_iterates_indexes_and_converts(run):
    """Truth: the study itself."""
    study = bc.open_run(run)
    assert [axis.data.axis for axis in study] == list(study.axes)
    assert len(study) == len(study.axes)
    name = next(iter(study.axes))
    assert study[name] is study.axes[name]
    with pytest.raises(KeyError, match="axis 'x' was not looked at"):
        study["x"]
    frame = study.to_dataframe()
    first = study[name].points[0]
    assert frame.loc[(name, first.label), "bad_probability"] == first.bad_probability
    assert len(frame) == sum(len(axis.points) for axis in study)
    shown = study.treatments_dataframe()
    for treatment in study[name].treatments:
        for order, value in treatment.log_evidence.items():
            assert shown.loc[(name, treatment.name, order), "log_evidence"] == value
    axis = study[name]
    assert [point.label for point in axis] == list(axis.to_dataframe().loc[name].index)
    assert axis[first.label] is first
    assert first.label in axis
    with pytest.raises(KeyError, match="no point 'none'"):
        axis["none"]
    posterior = axis.chosen.posterior
    assert axis.chosen.key.noise == "outlier-mixture"
    assert list(study.summary().loc[name].index) == list(posterior.names)
    sd = [p.sd for p in posterior.parameters]
    np.testing.assert_allclose(np.sqrt(np.diag(study.covariance())), sd, rtol=1e-9)
    assert set(study.to_arviz()[name].posterior.data_vars) == set(posterior.names)
