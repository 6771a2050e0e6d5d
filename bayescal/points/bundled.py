"""The data sets that come with bayescal."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING

from bayescal.points.correspondences import Correspondences
from bayescal.points.reader import load

if TYPE_CHECKING:  # points do not pay for the readers of views
    from bayescal.points.views.views import Views


def data_folder() -> Path:
    """Folder of the bundled data: inside the package, or beside it in a checkout."""
    package = Path(__file__).resolve().parents[1]
    inside = package / "data"
    return inside if inside.is_dir() else package.parent / "data"


def thesis() -> Correspondences:
    """Load the 57 correspondences of the thesis's Appendix A.

    Returns
    -------
    Correspondences
        World units are the appendix's (S = 150 multiplied out); camera position
        (330, 57, 0), image 1920 (assumed) by 1080 px, c counted from the bottom.
    """
    folder = data_folder() / "thesis"
    points = load(folder / "points.csv", folder / "setup.toml")
    return dataclasses.replace(points, source="thesis")


def chessboard() -> Views:
    """Load the corners of OpenCV's 13 photographs of a chessboard.

    Returns
    -------
    Views
        54 inner corners each, squares of 25 mm (as OpenCV's sample takes them), image 640
        by 480 px.
    """
    from bayescal.points.views.reader import load_views

    found = load_views(data_folder() / "chessboard" / "views.csv")
    return dataclasses.replace(found, source="chessboard")
