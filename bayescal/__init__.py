"""bayescal: Bayesian uncertainty analysis for camera calibration.

Each polynomial order of the world-to-pixel map (`compare`), each family of
camera models (`compare_families`) and each lens of many views (`calibrate`) is a
likelihood model. They are compared by goodness of fit, information criteria,
evidence and predictive accuracy, so that the choice can be defended. What was
chosen predicts (`predict`), locates (`locate`) and undistorts (`undistort`), with
its uncertainty. World coordinates are in any one unit, pixels in px.

>>> import bayescal as bc
>>> result = bc.compare(bc.thesis(), orders=range(1, 6))
>>> result.axes["r"].verdict.order
4
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from bayescal.version import __version__

# Public names and the modules they live in. They are imported on first use, so
# that `bayescal --help` does not pay for scipy.
_EXPORTS = {
    "BayescalError": "bayescal.errors",
    "InputError": "bayescal.errors",
    "Correspondences": "bayescal.points.correspondences",
    "Setup": "bayescal.points.setup",
    "Views": "bayescal.points.views.views",
    "load": "bayescal.points.reader",
    "load_setup": "bayescal.points.setup_file",
    "load_views": "bayescal.points.views.reader",
    "save": "bayescal.points.writer",
    "save_views": "bayescal.points.views.writer",
    "thesis": "bayescal.points.bundled",
    "chessboard": "bayescal.points.bundled",
    "calibrate": "bayescal.api.calibrate",
    "CalibratedCamera": "bayescal.prediction.calibrated.camera",
    "camera": "bayescal.api.camera",
    "keep_camera": "bayescal.prediction.calibrated.saved",
    "predict": "bayescal.api.camera",
    "locate": "bayescal.api.camera",
    "distances": "bayescal.api.camera",
    "locate_target": "bayescal.api.camera",
    "image_maps": "bayescal.api.image",
    "changed": "bayescal.api.image",
    "undistort": "bayescal.api.image",
    "undistortion": "bayescal.api.image",
    "compare": "bayescal.api.axes",
    "compare_families": "bayescal.api.families",
    "compare_polynomials": "bayescal.api.polynomials",
    "fit": "bayescal.api.axes",
    "fit_family": "bayescal.api.families",
    "fit_polynomial": "bayescal.api.polynomials",
    "fleet": "bayescal.api.fleet",
    "least_squares": "bayescal.api.polynomials",
    "open_run": "bayescal.report.runs",
    "opencv_camera": "bayescal.report.opencv",
    "FittedCamera": "bayescal.report.cameras.camera",
    "fitted_camera": "bayescal.report.cameras.fitted",
    "load_camera": "bayescal.report.cameras.read",
    "save_camera": "bayescal.report.cameras.write",
    "save_opencv": "bayescal.report.opencv",
    "save_report": "bayescal.report.page.page",
    "save_run": "bayescal.report.runs",
    "plot": "bayescal.report.figures.registry",
    "outliers": "bayescal.api.outliers",
    "reproduce": "bayescal.reproduction.procedure",
    "simulate": "bayescal.simulation",
}

__all__ = [
    "BayescalError",
    "CalibratedCamera",
    "Correspondences",
    "FittedCamera",
    "InputError",
    "Setup",
    "Views",
    "__version__",
    "calibrate",
    "camera",
    "changed",
    "chessboard",
    "compare",
    "compare_families",
    "compare_polynomials",
    "distances",
    "fit",
    "fit_family",
    "fit_polynomial",
    "fitted_camera",
    "fleet",
    "image_maps",
    "keep_camera",
    "least_squares",
    "load",
    "load_camera",
    "load_setup",
    "load_views",
    "locate",
    "locate_target",
    "open_run",
    "opencv_camera",
    "outliers",
    "plot",
    "predict",
    "reproduce",
    "save",
    "save_camera",
    "save_opencv",
    "save_report",
    "save_run",
    "save_views",
    "simulate",
    "thesis",
    "undistort",
    "undistortion",
]

if TYPE_CHECKING:
    from bayescal.api.axes import compare, fit
    from bayescal.api.calibrate import calibrate
    from bayescal.api.camera import camera, distances, locate, locate_target, predict
    from bayescal.api.families import compare_families, fit_family
    from bayescal.api.fleet import fleet
    from bayescal.api.image import changed, image_maps, undistort, undistortion
    from bayescal.api.outliers import outliers
    from bayescal.api.polynomials import compare_polynomials, fit_polynomial, least_squares
    from bayescal.errors import BayescalError, InputError
    from bayescal.points.bundled import chessboard, thesis
    from bayescal.points.correspondences import Correspondences
    from bayescal.points.reader import load
    from bayescal.points.setup import Setup
    from bayescal.points.setup_file import load_setup
    from bayescal.points.views.reader import load_views
    from bayescal.points.views.views import Views
    from bayescal.points.views.writer import save_views
    from bayescal.points.writer import save
    from bayescal.prediction.calibrated.camera import CalibratedCamera
    from bayescal.prediction.calibrated.saved import keep_camera
    from bayescal.report.cameras.camera import FittedCamera
    from bayescal.report.cameras.fitted import fitted_camera
    from bayescal.report.cameras.read import load_camera
    from bayescal.report.cameras.write import save_camera
    from bayescal.report.figures.registry import plot
    from bayescal.report.opencv import opencv_camera, save_opencv
    from bayescal.report.page.page import save_report
    from bayescal.report.runs import open_run, save_run
    from bayescal.reproduction.procedure import reproduce
    from bayescal.simulation import simulate


def __getattr__(name: str) -> Any:
    try:
        module = _EXPORTS[name]
    except KeyError:
        raise AttributeError(f"module 'bayescal' has no attribute {name!r}") from None
    value = getattr(import_module(module), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return list(__all__)
