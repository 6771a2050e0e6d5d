"""NumPy archives of object and image points, as OpenCV's users save them.

Arrays under usual names (``object_points`` or ``objpoints``, ``image_points`` or ``imgpoints``,
...): pixels (views, points, 2) or (views, points, 1, 2), NaN where a point is missing, and target
points of the same shape with 3, or once for all views; or one array per view, its number behind the
name. Camcal's archives (target_points, frame_0_indices, frame_0_detections, ...) likewise
(github.com/Robertleoj/camcal).
"""

from __future__ import annotations

from bayescal.points.views.formats.archive import is_archive, read_arrays
from bayescal.points.views.formats.arrays import assembled, image_size, known, views_of
from bayescal.points.views.formats.source import Source
from bayescal.points.views.views import Views

NAME = "NumPy archive"


def recognises(source: Source) -> bool:
    """Whether it is a zip archive and no workbook."""
    return is_archive(source.raw) and b"xl/workbook.xml" not in source.raw


def read(source: Source) -> Views:
    """Read the archive.

    Raises
    ------
    InputError
        Where it can't be used.
    """
    arrays = read_arrays(source.name, source.raw, known)
    return assembled(source, views_of(source, arrays), image_size(arrays))
