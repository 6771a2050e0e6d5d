"""``bayescal calibrate`` as a user runs it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from bayescal.cli import main


def test_table_verdict_and_document(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Truth: OpenCV's own boards support k1 k2; a pinhole is hopeless."""
    place = tmp_path / "lenses.json"
    options = ["--lens", "pinhole", "--lens", "radial 2", "--independent", "--json", str(place)]
    assert main(["calibrate", *options]) == 0
    shown = capsys.readouterr().out
    assert "Verdict: These views support radial 2, >99.9%: decided at 95%." in shown
    assert max(map(len, shown.splitlines())) <= 100
    document = json.loads(place.read_text())
    assert document["schema"] == "bayescal.lenses/1"
    assert [lens["name"] for lens in document["lenses"]] == ["radial 2", "pinhole"]
    assert document["lenses"][0]["rms_px"] == pytest.approx(0.18, abs=0.03)
    assert document["verdict"]["status"] == "decided"


@pytest.mark.parametrize(
    ("options", "why"),
    [
        (["--lens", "radial 99"], "order 99"),
        (["--lens", "none"], "lens 'none'"),
        (["--sigma", "-1"], "sigma must be a positive number"),
        (["--sigma", "replicates"], "sigma replicates"),
        (["nowhere.csv"], "nowhere.csv"),
    ],
)
def test_bad_input_is_one_line(
    options: list[str], why: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["calibrate", *options]) == 2
    said = capsys.readouterr().err
    assert why in said
    assert said.count("\n") == 1
