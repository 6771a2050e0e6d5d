"""Validations keep what comes of each data set, and go on from there."""

from argparse import Namespace
from pathlib import Path

from scripts.validation.sections import of_each

made = []


def doubled(seed: int, name: str) -> str:
    """What comes of a case, which is noted."""
    made.append((seed, name))
    return name * seed


def test_kept_cases_are_not_made_again(tmp_path: Path) -> None:
    """More sets, and one whose file is lost, are made; the others are read."""
    options = Namespace(workers=1, keep=str(tmp_path / "kept"))
    made.clear()
    assert of_each(doubled, [(1, "a"), (2, "b")], options) == ["a", "bb"]
    assert of_each(doubled, [(2, "b"), (3, "c")], options) == ["bb", "ccc"]
    assert made == [(1, "a"), (2, "b"), (3, "c")]
    for file in (tmp_path / "kept").iterdir():
        file.unlink()
    assert of_each(doubled, [(1, "a")], options) == ["a"]
    assert made[-1] == (1, "a")


def test_nothing_is_kept_unasked() -> None:
    """Without a folder every case is made."""
    made.clear()
    options = Namespace(workers=1, keep=None)
    of_each(doubled, [(1, "a")], options)
    of_each(doubled, [(1, "a")], options)
    assert len(made) == 2
