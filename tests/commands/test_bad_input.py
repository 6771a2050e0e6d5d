"""Bad input through the command: exit code 2, one clear line, nothing written."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from bayescal.cli import main
from tests.helpers.command import apart
from tests.helpers.points_files import HEADER, rows, text

GOOD = text(rows(30))
TWO_VALUES = text([(x, 7, 1, 100 * x + y, y) for x in (0, 1) for y in range(8)])
STATED = "[prior.r]\nmean = [960, 0]\nsd = [960, 960]\n[prior.c]\nmean = [540, 0]\nsd = [540, 9]\n"

Refuse = Callable[..., str]


def everything_in(folder: Path) -> dict[str, bytes | None]:
    return {str(path): path.read_bytes() if path.is_file() else None for path in folder.rglob("*")}


@pytest.fixture
def refuse(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Refuse:
    """Run a command that must be refused; return its one line of complaint."""

    def run(
        *arguments: str,
        points: str | bytes = GOOD,
        setup: str | None = None,
        command: str = "compare",
        output: Sequence[str] = ("--json", "result.json", "--out", "run"),
    ) -> str:
        content = points if isinstance(points, bytes) else points.encode()
        (tmp_path / "points.csv").write_bytes(content)
        if setup is not None:
            (tmp_path / "setup.toml").write_text(setup, encoding="utf-8")
            arguments = (*arguments, "--setup", "setup.toml")
        before = everything_in(tmp_path)
        monkeypatch.chdir(tmp_path)
        try:
            code = main([command, *arguments, *output])
        except SystemExit as stop:  # how argparse leaves
            code = int(stop.code or 0)
        out, err = capsys.readouterr()
        assert code == 2
        assert out == ""
        assert err.count("\n") == 1
        assert err.startswith("bayescal")
        assert err[:-1].isprintable()
        assert everything_in(tmp_path) == before
        return err

    return run


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (GOOD.replace(",r,c", ",r"), "points.csv:2: has 5 fields where the header has 4"),
        (GOOD.replace(",r,c", ",r,q"), "points.csv:1: no column 'c' among 'x,y,z,r,q'"),
        (GOOD.replace(",r,c", ",r,r"), "points.csv:1: column 'r' stands twice"),
        (f"{GOOD}1,2,3,four,5\n", "points.csv:32: r: 'four' where a number should be"),
        (f"{GOOD}1,2,3,nan,5\n", "points.csv:32: r: is nan"),
        (f"{GOOD}1,2,3,4,inf\n", "points.csv:32: c: is inf"),
        (f"{GOOD}1,2,3,1e300,5\n", "points.csv:32: r: is 1e+300"),
        (f"{GOOD}1,2,0,4,5\n", "points.csv:32: z is 0, in the camera's plane"),
        (f"{GOOD}1,2,-0.0,4,5\n", "points.csv:32: z is 0, in the camera's plane"),
        (f"{GOOD}1,2,1e-320,4,5\n", "points.csv:32: z is"),
        (f"{GOOD}1,2,3\n", "points.csv:32: has 3 fields where the header has 5"),
        ("", "points.csv: is empty"),
        (f"{HEADER}\n", "points.csv: there are no points"),
        (f"{HEADER},sigma_r\n1,2,3,4,5,0\n", "points.csv:2: sigma_r: is 0"),
        (GOOD.encode("utf-16"), "points.csv:1: is UTF-16"),
        (f"label,{HEADER}\né,1,2,3,4,5\n".encode("latin-1"), "points.csv:2: is not UTF-8"),
        (b"\x89PNG\0", "points.csv:1: holds a null byte"),
        (f'{HEADER}\n1,2,3,4,"5\n', "points.csv:2: "),
        (text(rows(5)), "order 5 has 6 coefficients for 5 points; the highest order that works"),
        (text(rows(5)), "works is 4"),
        (text(rows(1)), "has 6 coefficients for 1 point; no order works; add points"),
        (TWO_VALUES, "takes 2 distinct values, order 5 needs 6; the highest order that works is 1"),
        (text([rows(1)[0]] * 20), "takes 1 distinct value,"),
        (f"{GOOD}1e12,1e12,1,4,5\n", "takes 2 distinct values"),  # the rest shrinks to a point
    ],
)
def test_points_that_can_not_be_used(content: str | bytes, complaint: str, refuse: Refuse) -> None:
    assert complaint in refuse("points.csv", points=content)


@pytest.mark.parametrize(
    ("setup", "options", "complaint"),
    [
        ("[camera]\nposition = 'here'\n", [], "setup.toml:2: camera.position: must be a list"),
        ("[camera]\nroll = 1\n", [], "setup.toml:2: camera.roll: unknown key"),
        ("[image]\nwidth = -1\n", [], "setup.toml:2: image width must be"),
        ("[image\n", [], "setup.toml:1: is not valid TOML"),
        ("[image]\nc_from_bottom = true\n", [], "setup.toml:2: c counted from the bottom needs"),
        (STATED, ["--orders", "1-2"], "the stated prior has 2 entries but order 2 has 3"),
        (STATED, ["--orders", "1", "--tau", "0.1", "--prior", "stated"], "tau belongs to the fie"),
    ],
)
def test_setups_that_can_not_be_used(
    setup: str, options: list[str], complaint: str, refuse: Refuse
) -> None:
    assert complaint in refuse("points.csv", *options, setup=setup)


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (["--orders", "5-1"], "'5-1' runs backwards; write 1-5"),
        (["--orders", "0-3"], "order 0 is out of range"),
        (["--orders", "1-99"], "is out of range; orders go from 1 to 20"),
        (["--orders", "x"], "'x' is not a list of orders"),
        (["--orders", ""], "'' is not a list of orders"),
        (["--orders", "1,,2"], "'1,,2' is not a list of orders"),
        (["--orders", "1.5"], "'1.5' is not a list of orders"),
        (["--orders", "²"], "'²' is not a list of orders"),
        (["--orders=-1"], "'-1' is not a list of orders"),
        (["--sigma", "0"], "sigma"),
        (["--sigma", "-1"], "sigma"),
        (["--sigma", "-1e3"], "sigma"),
        (["--sigma", "nan"], "sigma"),
        (["--sigma", "inf"], "sigma"),
        (["--sigma", "loud"], "sigma: 'loud' is"),
        (["--tau", "-1"], "tau must be"),
        (["--tau", "0"], "tau must be"),
        (["--tau", "nan"], "tau must be"),
        (["--tau", "0.05", "--prior", "flat"], "tau belongs to the field prior"),
        (["--prior", "stated"], "no prior is stated"),
        (["--prior", "vague"], "invalid choice: 'vague'"),
        (["--axis", "x"], "invalid choice: 'x'"),
        (["--ess", "1"], "ess must be from 100"),
        (["--ess", "1e3"], "invalid int value: '1e3'"),
        (["--seed", "-1"], "seed must not be negative"),
        (["--seed", "0.5"], "invalid int value: '0.5'"),
        (["--image-width", "0"], "image width must be from 1"),
        (["--image-width", "-1920"], "image width must be from 1"),
        (["--image-height", "1e-300"], "image height must be from 1"),
        (["--c-from-bottom"], "needs the image height"),
        (["--camera-position", "0", "0"], "expected 3 arguments"),
        (["--camera-position", "0", "0", "nan"], "camera position must be three finite"),
        (["--camera-position", "0", "1e300", "0"], "camera position must be three finite"),
        (["--camera-position", "1e50", "1e50", "1e50"], "takes 1 distinct value,"),
        (["--setup", "."], "is a directory; give a TOML setup file"),
        (["--setup", "none.toml"], "none.toml: there is no such file"),
        (["second.csv"], "unrecognized arguments: second.csv; see bayescal compare --help"),
        (["--frobnicate\nloudly"], "unrecognized arguments: --frobnicate loudly"),
    ],
)
def test_options_that_can_not_be_used(options: list[str], complaint: str, refuse: Refuse) -> None:
    assert complaint in refuse("points.csv", *options)


def test_points_that_can_not_be_read(refuse: Refuse) -> None:
    assert "none.csv: there is no such file" in refuse("none.csv")
    assert ".: is a directory" in refuse(".")
    assert "points.csv/x: not a directory" in refuse("points.csv/x")
    assert "there is no such file" in refuse("a\nb\x1b[31m.csv")


def test_fit_needs_an_order_in_range(refuse: Refuse) -> None:
    assert "give --order-r, --order-c or both" in refuse(command="fit")
    assert "order 0 is out of range" in refuse("--order-r", "0", command="fit")
    assert "order 21 is out of range" in refuse("--order-c", "21", command="fit")
    assert "order 30" not in refuse("points.csv", "--order-r", "-1", command="fit")


def test_unknown_command(refuse: Refuse) -> None:
    assert "invalid choice: 'frobnicate'" in refuse(command="frobnicate", output=())


@pytest.mark.parametrize(
    ("output", "complaint"),
    [
        (["--json", "points.csv"], "points.csv: exists; choose another name or add --force"),
        (["--json", "."], "is a directory; name a file"),
        (["--json", ".", "--force"], "is a directory; name a file"),
        (["--json", ""], "is a directory; name a file"),
        (["--json", "none/result.json"], "there is no folder none"),
        (["--json", "points.csv/result.json"], "points.csv/result.json: not a directory"),
        (["--json", "n" * 300], "file name too long"),
        (["--json", "pipe", "--force"], "pipe: is not a regular file"),
        (["--json", "/proc/result.json"], "/proc/result.json: "),  # not even root may
        (["--out", "none/run"], "there is no folder none"),
        (["--out", "points.csv"], "points.csv: exists and is not a run"),
        (["--out", "points.csv", "--force"], "points.csv: exists and is not a run"),
        (["--out", "."], "exists and is not a run"),
        (["--out", ".", "--force"], "exists and is not a run"),
        (["--out", "folder", "--force"], "folder: exists and is not a run"),
        (["--out", "link", "--force"], "link: exists and is not a run"),
        (["--out", "dangling", "--force"], "dangling: exists and is not a run"),
        (["--out", "n" * 300], "file name too long"),
        (["--out", "/proc/run"], "/proc/run"),
        (["--out", "earlier"], "earlier: holds an earlier run; choose another name or add --force"),
        (["--out", "new", "--json", "new"], "new"),
        (["--out", "new", "--json", "new/result.json"], "new/result.json: there is no folder new"),
    ],
)
def test_output_that_can_not_be_written(
    output: list[str], complaint: str, refuse: Refuse, tmp_path: Path
) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "thesis.tex").write_text("precious")
    (tmp_path / "earlier").mkdir()
    (tmp_path / "earlier" / "result.json").write_text("{}")
    (tmp_path / "link").symlink_to(tmp_path / "folder")
    (tmp_path / "dangling").symlink_to(tmp_path / "nowhere")
    os.mkfifo(tmp_path / "pipe")
    short = ("points.csv", "--orders", "1", "--axis", "r", "--ess", "100")
    assert complaint in refuse(*short, output=output)


@pytest.mark.parametrize(
    "arguments",
    [["points.csv", "--orders", "5-1"], ["points.csv"], ["-"], ["--setup", "points.csv"]],
)
def test_the_real_command_refuses_alike(arguments: list[str], tmp_path: Path) -> None:
    (tmp_path / "points.csv").write_text(f"{HEADER}\n1,2,3,4,oops\n")
    before = everything_in(tmp_path)
    found = apart("compare", *arguments, "--out", "run", folder=tmp_path)
    assert found.returncode == 2
    assert found.stdout == b""
    assert found.stderr.count(b"\n") == 1
    assert b"Traceback" not in found.stderr
    assert everything_in(tmp_path) == before
