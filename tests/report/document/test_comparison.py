"""The result document: its schema, its keys, and null for what is unavailable."""

from __future__ import annotations

import datetime
import json
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from jsonschema import Draft202012Validator

import bayescal as bc
from bayescal.points.setup import StatedPrior
from bayescal.report.document.comparison import comparison_document
from bayescal.report.document.shared import dumps, schema
from tests.helpers.points_files import rows

NUMBER, TEXT, TRUTH, WHOLE = (int, float), str, bool, int
NULL = type(None)
MAYBE = (int, float, NULL)
SUMMARY = {
    "mean": NUMBER, "sd": NUMBER, "interval": [NUMBER], "interval_probability": NUMBER,
    "mcse_mean": NUMBER, "ess_bulk": NUMBER, "ess_tail": NUMBER, "rhat": NUMBER,
    "exact_mean": NUMBER, "exact_sd": NUMBER,
}  # fmt: skip
ORDER = {
    **dict.fromkeys(["order", "n_coefficients", "n_parameters", "dof"], WHOLE),
    "rss_px2": NUMBER,
    **dict.fromkeys(["sigma_hat_px", "chi2", "chi2_reduced", "p_value", "f_p_value"], MAYBE),
    **dict.fromkeys(["log_likelihood_max", "aic", "aicc", "bic"], MAYBE),
    **dict.fromkeys(["log_evidence", "log_evidence_error", "probability"], MAYBE),
    **dict.fromkeys(["elpd_loo", "elpd_loo_se", "elpd_diff", "elpd_diff_se"], MAYBE),
    **dict.fromkeys(["p_loo", "pareto_k_max"], MAYBE),
    "coefficients": [{"name": TEXT, "mle": NUMBER, **SUMMARY}],
    "sigma": (dict, NULL),
    "sampling": {
        "sampler": TEXT, "walkers": WHOLE, "steps": WHOLE, "draws": WHOLE, "acceptance": NUMBER,
        "autocorrelation_time": NUMBER, "converged": TRUTH, "agrees_with_exact": TRUTH,
    },
}  # fmt: skip
AXIS = {
    "regressor": TEXT,
    "n": WHOLE,
    "domain": [NUMBER],
    "noise": {
        "kind": TEXT, "sigma": TEXT, "sigma_px": MAYBE, "sigma_bounds_px": (list, NULL),
        "reference_sigma_px": MAYBE, "reference": TEXT, "reference_dof": (int, NULL),
        "scatter_px": MAYBE, "scatter_dof": (int, NULL),
    },
    "prior": {
        "name": TEXT, "basis": TEXT, "size_px": NUMBER, "mean_px": (list, NULL),
        "sd_px": (list, NULL), "tau": (dict, NULL),
    },
    "orders": [ORDER],
    "verdict": {
        "order": (int, NULL), "plausible": [WHOLE], "decided": TRUTH,
        "log_bayes_factor_to_next": MAYBE, "strength": (str, NULL), "caveats": [TEXT],
        "text": TEXT,
    },
}  # fmt: skip
DOCUMENT = {
    "schema": TEXT,
    "provenance": {
        **dict.fromkeys(["bayescal", "python", "emcee", "numpy", "command", "created"], TEXT),
        "seed": WHOLE,
    },
    "data": {
        "source": TEXT,
        "sha256": (str, NULL),
        "n_points": WHOLE,
        "image": {"width_px": MAYBE, "height_px": MAYBE},
        "camera_position": (list, NULL),
    },
    "family": TEXT,
    "verdict": {"orders": dict, "text": TEXT},
}  # fmt: skip


def conforms(value: Any, shape: Any, place: str = "document") -> None:
    """Check that the value has every key of the shape, of the right type."""
    if isinstance(shape, dict):
        assert isinstance(value, dict), place
        for key, inner in shape.items():
            assert key in value, f"{place}.{key}"
            conforms(value[key], inner, f"{place}.{key}")
    elif isinstance(shape, list):
        assert isinstance(value, list), place
        for i, item in enumerate(value):
            conforms(item, shape[0], f"{place}[{i}]")
    else:
        assert isinstance(value, shape), f"{place} is {value!r}"
        assert shape in (TRUTH, (dict, NULL)) or not isinstance(value, bool), place


def floats(value: Any) -> Iterator[float]:
    if isinstance(value, dict | list):
        for item in value.values() if isinstance(value, dict) else value:
            yield from floats(item)
    elif isinstance(value, float):
        yield value


def points(n: int = 20, noise: float = 1.0, **more: Any) -> bc.Correspondences:
    table = np.array(rows(n, noise))
    return bc.Correspondences.from_arrays(table[:, :3], table[:, 3:], **more)


def compared(given: bc.Correspondences, **options: Any) -> dict[str, Any]:
    found = bc.compare(given, options.pop("orders", [1, 2]), ess=100, **options)
    return comparison_document(found, "bayescal compare")


STATED = bc.Setup(
    width=1920, height=1080, priors={a: StatedPrior((9, 0, 0), (999, 999, 9)) for a in ("r", "c")}
)
# What is compared, with which options.
CASES: dict[str, tuple[bc.Correspondences, dict[str, Any]]] = {
    "thesis": (bc.thesis(), {"orders": [1, 4, 5]}),
    "one axis": (points(), {"axis": "c"}),
    "defended": (points(), {"defend": True}),
    "known sigma": (points(), {"sigma": 0.8}),
    "sigma per point": (points(sigma_r=np.linspace(1, 2, 20)), {}),
    "flat prior": (points(), {"prior": "flat"}),
    "fixed tau": (points(), {"tau": 0.05}),
    "stated prior": (points(setup=STATED), {}),
    "exact fit": (points(noise=0), {}),
    "as many coefficients as points": (points(3), {}),
    "order 12": (points(), {"orders": [12]}),
}


@pytest.fixture(scope="module", params=CASES)
def case(request: pytest.FixtureRequest) -> tuple[str, dict[str, Any]]:
    given, options = CASES[request.param]
    return request.param, compared(given, **options)


def test_schema_is_one() -> None:
    Draft202012Validator.check_schema(schema("comparison"))


def test_documents_obey_the_schema(case: tuple[str, dict[str, Any]]) -> None:
    Draft202012Validator(schema("comparison")).validate(case[1])


def test_schema_refuses_documents_that_lack_or_garble_something() -> None:
    validator = Draft202012Validator(schema("comparison"))

    def faults(*path: str | int, value: Any = ...) -> int:
        broken = json.loads(json.dumps(sound))
        node = broken
        for step in path[:-1]:
            node = node[step]
        if value is ...:
            del node[path[-1]]
        else:
            node[path[-1]] = value
        return len(list(validator.iter_errors(broken)))

    sound = compared(points(), axis="r")
    order = ("axes", "r", "orders", 0)
    assert list(validator.iter_errors(sound)) == []
    assert faults("schema", value="bayescal.comparison/2")
    for key in ("provenance", "data", "family", "axes", "verdict"):
        assert faults(key)
    for key in ("rss_px2", "chi2", "aic", "log_evidence", "coefficients", "sampling"):
        assert faults(*order, key)
        assert faults(*order, key, value="7")
    assert faults(*order, "coefficients", 0, "mean", value=None)
    assert faults("axes", "q", value=sound["axes"]["r"])
    assert not faults("later", value="keys that later versions add are allowed")


def test_every_promised_key_is_there_with_its_type(case: tuple[str, dict[str, Any]]) -> None:
    name, found = case
    conforms(found, DOCUMENT)
    assert set(found["axes"]) == ({"c"} if name == "one axis" else {"r", "c"})
    for axis in found["axes"].values():
        conforms(axis, AXIS)
        for order in axis["orders"]:
            if order["sigma"] is not None:
                conforms(order["sigma"], SUMMARY)


def test_no_number_is_nan_or_infinite(case: tuple[str, dict[str, Any]]) -> None:
    values = list(floats(case[1]))
    assert len(values) > 50
    assert all(map(math.isfinite, values))
    assert json.loads(dumps(case[1])) == case[1]  # full precision


def test_null_is_what_can_not_be_had(case: tuple[str, dict[str, Any]]) -> None:
    name, found = case
    for letter, axis in found["axes"].items():
        own_sigma = letter == "r" and name == "sigma per point"
        known = name == "known sigma" or own_sigma
        noise = axis["noise"]
        assert (noise["sigma"] == "known") == known
        assert (noise["sigma_bounds_px"] is None) == known
        assert (noise["sigma_px"] is None) == (not known or own_sigma)
        assert (axis["verdict"]["order"] is None) == (name == "flat prior")
        assert (axis["prior"]["tau"] is None) == (name in ("flat prior", "stated prior"))
        for order in axis["orders"]:
            exact = name == "exact fit" or order["dof"] == 0
            assert (order["sigma"] is None) == known
            assert (order["p_value"] is None) == (not known)
            assert (order["log_evidence"] is None) == (name == "flat prior")
            assert (order["probability"] is None) == (name == "flat prior")
            assert (order["aic"] is None) == exact
            assert (order["aicc"] is None) == (known or exact or order["dof"] < 3)
            assert (order["elpd_loo"] is None) == (name != "defended")


def test_what_is_said_of_the_thesis() -> None:
    found = compared(bc.thesis(), orders=[4, 5], seed=3)
    assert found["schema"] == "bayescal.comparison/1"
    assert found["provenance"]["seed"] == 3
    created = datetime.datetime.fromisoformat(found["provenance"]["created"])
    assert created.utcoffset() == datetime.timedelta(0)
    assert found["data"]["source"] == "thesis"
    assert found["data"]["n_points"] == 57
    assert found["data"]["image"] == {"width_px": 1920, "height_px": 1080}
    assert found["data"]["camera_position"] == [330, 57, 0]
    r, c = found["axes"]["r"], found["axes"]["c"]
    assert (r["regressor"], c["regressor"]) == ("x/z", "y/z")
    assert r["domain"] == [-0.6, 0.6]
    assert (r["noise"]["scatter_dof"], c["noise"]["scatter_dof"]) == (35, 26)
    assert r["noise"]["scatter_px"] == pytest.approx(2.51, abs=0.005)
    assert c["noise"]["scatter_px"] == pytest.approx(1.09, abs=0.005)
    assert r["prior"]["mean_px"] == [960, 0, 0, 0, 0, 0]
    assert r["prior"]["sd_px"] == [960, 960, None, None, None, None]
    assert r["prior"]["tau"] == {"kind": "log-uniform", "bounds": [0.01 / 1920, 0.5]}
    assert [x["name"] for x in r["orders"][0]["coefficients"]] == [f"alpha_{j}" for j in range(5)]
    assert [x["name"] for x in c["orders"][0]["coefficients"]] == [f"beta_{j}" for j in range(5)]
    assert [o["rss_px2"] for o in r["orders"]] == pytest.approx([737.9, 736.7], abs=0.05)
    assert [o["rss_px2"] for o in c["orders"]] == pytest.approx([599.1, 599.0], abs=0.05)
    assert found["verdict"]["orders"] == {"r": r["verdict"]["order"], "c": c["verdict"]["order"]}


def test_arrays_without_a_camera_have_a_document_too() -> None:
    x = np.linspace(-1, 1, 12)
    found = comparison_document(bc.compare_polynomials(x, np.sin(3 * x), [1, 3], ess=100), "python")
    Draft202012Validator(schema("comparison")).validate(found)
    conforms(found, DOCUMENT)
    conforms(found["axes"]["y"], AXIS)
    assert found["data"]["camera_position"] is None
    assert found["family"] == "polynomial"


def test_nan_is_never_written() -> None:
    with pytest.raises(ValueError, match="not JSON compliant"):
        dumps({"value": math.nan})


def test_joint_probabilities_are_products_that_sum_to_one() -> None:
    """Independent axes: P(r, c) = P(r) P(c); one axis alone has none."""
    found = comparison_document(bc.compare(bc.thesis(), [1, 2, 4], ess=100), "")
    joint = found["verdict"]["joint"]
    r, c = ([o["probability"] for o in found["axes"][a]["orders"]] for a in "rc")
    assert joint["orders"] == {"r": [1, 2, 4], "c": [1, 2, 4]}
    assert joint["probability"] == [[p * q for q in c] for p in r]
    assert abs(sum(map(sum, joint["probability"])) - 1) < 1e-12
    alone = comparison_document(bc.compare(bc.thesis(), [1, 2], axis="r", ess=100), "")
    assert alone["verdict"]["joint"] is None
