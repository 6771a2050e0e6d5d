"""Which cameras files, patterns and manifests mean."""

from __future__ import annotations

import pytest

import bayescal as bc
from bayescal.fleets.listed import Listed, listed


@pytest.fixture
def folder(tmp_path, monkeypatch):
    for name in ("a/1.csv", "a/2.csv", "b/1.csv"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("x,y,z,r,c\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.usefixtures("folder")
def test_patterns():
    assert listed(["a/*.csv"]) == [Listed("1", "a/1.csv"), Listed("2", "a/2.csv")]
    names = [camera.name for camera in listed(["a/*.csv", "b/1.csv", "a/1.csv"])]
    assert names == ["a/1.csv", "a/2.csv", "b/1.csv"]  # each once, told apart


def test_manifest(folder):
    (folder / "list.csv").write_text("\ufeffcamera,File,setup\nleft,a/1.csv,s.toml\n\n,b/1.csv,\n")
    assert listed(["list.csv"]) == [
        Listed("left", "a/1.csv", "s.toml"),
        Listed("1", "b/1.csv", None),
    ]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("file\n", "lists no cameras"),
        ("file,lens\na/1.csv,x\n", r"list.csv:1: column 'lens' is none of file, camera, setup"),
        ("file,camera\na/1.csv\n", r"list.csv:2: has 1 field, the header 2"),
        ("file,camera\n,x\n", r"list.csv:2: file: is empty"),
        ("file,camera\na/1.csv,x\na/2.csv,x\n", r"list.csv:3: camera 'x' is named in line 2, too"),
    ],
)
def test_bad_manifests(folder, text, message):
    (folder / "list.csv").write_text(text)
    with pytest.raises(bc.InputError, match=message):
        listed(["list.csv"])


@pytest.mark.usefixtures("folder")
def test_nothing():
    with pytest.raises(bc.InputError, match="no such file, such as 'cameras/"):
        listed(["c/*.csv"])
