"""How parameters move together, in every outlet: the draws' own covariance."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import bayescal as bc
from bayescal.comparison.faces.convert import Converts
from bayescal.inference.correlation import correlation_of
from bayescal.report.runs import kind_of


def check(found: Converts, table: pd.DataFrame, told: dict[str, list[list[float]]]) -> None:
    """Compare a model's rows of the table and its part of the document with what it says itself."""
    own = found.covariance()
    assert told["parameters"] == list(own.index)
    np.testing.assert_allclose(told["matrix"], own, rtol=1e-12)
    np.testing.assert_allclose(told["correlation"], correlation_of(own.to_numpy()), rtol=1e-12)
    pairs = table.set_index(["parameter", "other"])
    for (name, other), row in pairs.iterrows():
        assert row.covariance == pytest.approx(own.loc[name, other], rel=1e-12)
        if name == other:
            assert row.correlation == pytest.approx(1)


@pytest.mark.parametrize("made", ["run", "families_run"])
def test_table_document_and_python_agree(made: str, request: pytest.FixtureRequest):
    run: Path = request.getfixturevalue(made)
    document = json.loads((run / "result.json").read_text(encoding="utf-8"))
    result = bc.open_run(run)
    models = kind_of(result).models(result)
    table = pd.read_csv(run / "covariance.csv", keep_default_na=False)
    assert list(dict.fromkeys(table.model)) == list(models)
    if made == "run":
        told = [
            order["covariance"] for axis in document["axes"].values() for order in axis["orders"]
        ]
    else:
        told = [model["covariance"] for model in document["families"]["models"]]
    for (name, found), one in zip(models.items(), told, strict=True):
        check(found, table[table.model == name], one)


def test_a_parameter_that_does_not_vary_has_no_correlation():
    found = correlation_of(np.array([[4.0, 0.0, 1.0], [0.0, 0.0, 0.0], [1.0, 0.0, 1.0]]))
    assert found[0, 2] == 0.5
    assert np.isnan(found[1]).all()
