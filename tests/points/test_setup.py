"""Setup files: what is read, and what every complaint says."""

from __future__ import annotations

from pathlib import Path

import pytest

import bayescal as bc
from tests.helpers.points_files import write

FULL = """
[camera]
position = [330, 57.5, -1e1]   # world units

[image]
width = 1920
height = 1080.0
c_from_bottom = true
assumed = ["width", "position"]

[prior.c]
mean = [540, 0]
sd = [540, 1e-3]
"""


def load(folder: Path, content: str | bytes) -> bc.Setup:
    return bc.load_setup(write(folder, content, "setup.toml"))


def test_everything_that_can_be_said(tmp_path: Path) -> None:
    setup = load(tmp_path, FULL)
    assert setup.position == (330.0, 57.5, -10.0)
    assert (setup.width, setup.height, setup.c_from_bottom) == (1920.0, 1080.0, True)
    assert setup.assumed == ("width", "position")
    assert setup.size("r") == 1920.0
    assert setup.size("c") == 1080.0
    assert set(setup.priors) == {"c"}
    assert setup.priors["c"].mean == (540.0, 0.0)
    assert setup.priors["c"].sd == (540.0, 0.001)


def test_nothing_said_is_the_default(tmp_path: Path) -> None:
    assert load(tmp_path, "") == bc.Setup()
    assert load(tmp_path, "# nothing\n[camera]\n[image]\n") == bc.Setup()


@pytest.mark.parametrize(
    "content",
    [
        "camera = {position = [1, 2, 3]}\nimage.width = 640\n",
        "camera.position = [1, 2, 3]\r\nimage = {width = 640}\r\n",
        "\ufeff[camera]\nposition = [\n  1,\n  2,\n  3,\n]\n['image']\n\"width\" = 6_40\n",
    ],
    ids=["inline and dotted", "crlf", "byte-order mark and quotes"],
)
def test_written_in_other_ways_it_is_the_same_setup(content: str, tmp_path: Path) -> None:
    assert load(tmp_path, content) == bc.Setup(position=(1, 2, 3), width=640)


# What stands in the file, and what the complaint must say.
BAD = {
    "unknown table": ("[camera]\n[lens]\nk1 = 0\n", ":2: lens: unknown key"),
    "unknown key": ("[camera]\nposition = [0, 0, 0]\nroll = 1\n", ":3: camera.roll: unknown key"),
    "key in the wrong table": ("[camera]\nwidth = 9\n[image]\nwidth = 9\n", ":2: camera.width"),
    "same key in two tables": ("[image]\nwidth = 9\n[camera]\nwidth = 9\n", ":4: camera.width"),
    "unknown axis": ("[prior.q]\nmean = [1]\nsd = [1]\n", ":1: prior.q: unknown key"),
    "dotted unknown key": ("\nimage.depth = 3\n", ":2: image.depth: unknown key"),
    "inline unknown key": ("\nimage = {depth = 3}\n", ":2: image.depth: unknown key"),
    "camera is no table": ("camera = 1\n", ":1: camera: must be a table"),
    "prior is no table": ("\nprior = [1]\n", ":2: prior: must be a table"),
    "prior of r is no table": ("[prior]\nr = 1\n", ":2: prior.r: must be a table"),
    "prior twice": ("[[prior.r]]\nmean = [1]\nsd = [1]\n", ":1: prior.r: must be a table"),
    "position a string": ("[camera]\nposition = '0 0 0'\n", ":2: camera.position: must be a list"),
    "position of two": ("[camera]\nposition = [1, 2]\n", ":2: camera.position: must have 3"),
    "position with text": ("[camera]\nposition = [1, 2, 'z']\n", ":2: camera.position: must be"),
    "position with truth": ("[camera]\nposition = [1, 2, true]\n", ":2: camera.position: must be"),
    "position nan": ("[camera]\n\nposition = [1, nan, 2]\n", ":3: the camera position must be"),
    "position inf": ("[camera]\nposition = [1, -inf, 2]\n", ":2: the camera position must be"),
    "position 1e100": ("[camera]\nposition = [1, 1e100, 2]\n", ":2: the camera position must be"),
    "width a string": ("[image]\nwidth = '1920'\n", ":2: image.width: must be a number"),
    "width a date": ("[image]\nwidth = 1920-01-01\n", ":2: image.width: must be a number"),
    "width true": ("[image]\nwidth = true\n", ":2: image.width: must be a number"),
    "width 0": ("[image]\nheight = 9\nwidth = 0\n", ":3: image width must be from 1 to"),
    "width -1": ("[image]\nwidth = -1920\n", ":2: image width must be from 1 to .* not -1920"),
    "width 1e-300": ("[image]\nwidth = 1e-300\n", ":2: image width must be from 1 to"),
    "height nan": ("[image]\nheight = nan\n", ":2: image height must be .* not nan"),
    "height inf": ("[image]\nheight = inf\n", ":2: image height must be .* not inf"),
    "height of 400 digits": (f"[image]\nheight = {'9' * 400}\n", ":2: image height must be"),
    "height of 5000 digits": (f"[image]\nheight = {'9' * 5000}\n", ": .* a number too long"),
    "c_from_bottom a string": ("[image]\nc_from_bottom = 'yes'\n", ":2: image.c_from_bottom: must"),
    "c_from_bottom 1": ("[image]\nc_from_bottom = 1\n", ":2: image.c_from_bottom: must be true or"),
    "no height": ("[image]\nwidth = 9\nc_from_bottom = true\n", ":3: c counted .* needs the image"),
    "assumed a string": ("[image]\nassumed = 'width'\n", ":2: image.assumed: must be a list"),
    "assumed unknown": ("[image]\nassumed = ['depth']\n", ":2: image.assumed: must be a list"),
    "assumed a table": ("[image]\nassumed = [{a = 1}]\n", ":2: image.assumed: must be a list"),
    "prior without sd": ("\n[prior.r]\nmean = [1]\n", ":2: prior.r.sd: must be a list of numbers"),
    "prior of two lengths": ("[prior.r]\nmean = [1]\nsd = [1, 2]\n", ":1: prior.r: mean has 1"),
    "sd 0": ("[prior.r]\nmean = [1]\nsd = [0]\n", ":1: prior.r: every sd must be"),
    "sd -1 of c": ("[prior.r]\nmean=[1]\nsd=[1]\n[prior.c]\nmean=[1]\nsd=[-1]\n", ":4: prior.c"),
    "sd nan": ("[prior.r]\nmean = [1]\nsd = [nan]\n", ":1: prior.r: every sd must be"),
    "sd 1e-300": ("[prior.r]\nmean = [1]\nsd = [1e-300]\n", ":1: prior.r: every sd must be"),
    "sd 1e300": ("[prior.r]\nmean = [1]\nsd = [1e300]\n", ":1: prior.r: every sd must be"),
    "mean inf": ("[prior.r]\nmean = [inf]\nsd = [1]\n", ":1: prior.r: every mean must be"),
    "mean 1e300": ("[prior.r]\nmean = [1e300]\nsd = [1]\n", ":1: prior.r: every mean must be"),
    "unknown entry": ("[report]\nauthor = 'A'\n", ":2: report.author: unknown key"),
    "title a number": ("[report]\n\ntitle = 7\n", ":3: title must be text"),
    "title of two lines": ('[report]\ntitle = "a\\nb"\n', ":2: title must be one line of at most"),
    "serial too long": (f"[report]\nserial = '{'9' * 201}'\n", ":2: serial must be one line of"),
    "report is no table": ("report = 1\n", ":1: report: must be a table"),
    "not TOML": ("[image]\nwidth = 1920\nheight =\n", ":3: is not valid TOML"),
    "table not closed": ("[image\n", ":1: is not valid TOML"),
    "list not closed": ("[camera]\nposition = [1,\n", ":2: is not valid TOML"),
    "key twice": ("[image]\nwidth = 1\nwidth = 2\n", ":3: is not valid TOML"),
    "a CSV file": ("x,y,z,r,c\n1,2,3,4,5\n", ":1: is not valid TOML"),
    "nested deeply": (f"a = {'[' * 20_000}{']' * 20_000}\n", ": nested too deeply"),
    "binary": (b"[image]\nwidth = \0\n", ":2: holds a null byte"),
    "utf-16": ("[image]\n".encode("utf-16"), ":1: is UTF-16 text"),
    "latin-1": ("[image]\n# \xe9\n".encode("latin-1"), ":2: is not UTF-8 text"),
}


@pytest.mark.parametrize("name", BAD)
def test_complaint_is_one_line_with_the_place(name: str, tmp_path: Path) -> None:
    content, complaint = BAD[name]
    with pytest.raises(bc.InputError, match=complaint) as caught:
        load(tmp_path, content)
    message = str(caught.value)
    assert message.startswith(f"{tmp_path / 'setup.toml'}:")
    assert len(message.splitlines()) == 1


def test_complaint_about_a_file_that_can_not_be_read(tmp_path: Path) -> None:
    loop = tmp_path / "loop.toml"
    loop.symlink_to(loop)
    for path, complaint in [
        (tmp_path, "is a directory"),
        (tmp_path / "none.toml", "there is no such file"),
        (loop, "symbolic links"),
    ]:
        with pytest.raises(bc.InputError, match=f"{path.name}: .*{complaint}"):
            bc.load_setup(path)
