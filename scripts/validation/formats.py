"""Files of mrcal, read and written, against mrcal's own reader, writer and projection."""

from __future__ import annotations

import os
import tempfile
import warnings
from pathlib import Path

import numpy as np

import bayescal as bc
from bayescal.cameras.camera import Camera
from bayescal.cameras.lenses import lens_named
from bayescal.report.cameras.camera import FittedCamera

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # it finds no plotting library, which nothing here needs
    import mrcal

COLUMNS, ROWS, SQUARE = 9, 6, 0.025
INTRINSICS = np.array([534.0, 533.0, 342.0, 234.0])
K = {"k1": -0.28, "k2": 0.03, "p1": 1e-3, "p2": -4e-4, "k3": 0.1, "k4": 0.02, "k5": -0.01}
K |= {"k6": 0.003, "s1": 1e-3, "s2": -2e-4, "s3": 5e-4, "s4": 1e-4}
LENSES = {
    "pinhole": lens_named("radial", order=0, tangential=False),
    "radial 1": lens_named("radial", order=1, tangential=False),
    "radial 3": lens_named("radial", order=3, tangential=False),
    **{name: lens_named(name) for name in ("opencv4", "opencv5", "opencv8", "opencv12")},
    "thin-prism": lens_named("thin-prism"),
}


def observations(views: bc.Views) -> np.ndarray:
    """Bring the bundled corners to mrcal's form, some weighted and some not seen."""
    pixels = views.pixels.reshape(len(views), ROWS, COLUMNS, 2)
    seen = np.concatenate([pixels, np.ones((*pixels.shape[:3], 1))], axis=3)
    seen[1, 2, 3, 2] = -1.0
    seen[2, 0, :4, 2] = 0.5
    return seen


def differences(found: bc.Views, seen: np.ndarray) -> tuple[float, float, float]:
    """Largest differences of pixels, target points and weights from mrcal's."""
    flat = seen.reshape(len(seen), -1, 3)
    there = flat[..., 2] > 0
    board = mrcal.ref_calibration_object(COLUMNS, ROWS, SQUARE).reshape(-1, 3)
    target = np.concatenate([board[row] for row in there])
    assert found.sigma is not None, "weights differ"
    return (
        float(np.abs(found.pixels - flat[there][:, :2]).max()),
        float(np.abs(found.world - target).max()),
        float(np.abs(1 / found.sigma[:, 0] - flat[there][:, 2]).max()),
    )


def corners(seen: np.ndarray) -> tuple[float, float, float]:
    """Write corners.vnl and read it with both."""
    lines = ["# filename x y level"]
    for i, view in enumerate(seen):
        for r, c, weight in view.reshape(-1, 3).tolist():
            level = "-" if weight < 0 else f"{-np.log2(weight):.0f}"
            lines.append(f"frame{i:02d}-cam0.jpg {r!r} {c!r} {level}")
    Path("corners.vnl").write_text("\n".join(lines))
    theirs, _, _ = mrcal.compute_chessboard_corners(
        COLUMNS, ROWS, globs_per_camera=("*-cam0.jpg",), corners_cache_vnl="corners.vnl", jobs=-1
    )
    board = {"board": f"{COLUMNS}x{ROWS}", "square": SQUARE}
    return differences(bc.load_views("corners.vnl", **board), theirs)


def cameramodel(seen: np.ndarray) -> tuple[float, float, float]:
    """Have mrcal write a model with its optimization inputs, and read it."""
    frames = len(seen)
    inputs = {
        "intrinsics": INTRINSICS[None].copy(),
        "rt_cam_ref": np.zeros((0, 6)),
        "rt_ref_frame": np.tile([0.0, 0, 0, 0, 0, 1], (frames, 1)),
        "points": None,
        "observations_board": seen.copy(),
        "indices_frame_camintrinsics_camextrinsics": np.column_stack(
            [np.arange(frames), np.zeros(frames), -np.ones(frames)]
        ).astype(np.int32),
        "observations_point": None,
        "indices_point_camintrinsics_camextrinsics": None,
        "lensmodel": "LENSMODEL_PINHOLE",
        "imagersizes": np.array([[640, 480]], dtype=np.int32),
        "calibration_object_spacing": SQUARE,
        "verbose": False,
    }
    model = mrcal.cameramodel(optimization_inputs=inputs, icam_intrinsics=0, icam_extrinsics=-1)
    model.write("made.cameramodel")
    found = bc.load_views("made.cameramodel")
    assert (found.width, found.height) == (640, 480)
    return differences(found, seen)


def main() -> None:
    """Print the largest differences."""
    seen = observations(bc.chessboard())
    os.chdir(tempfile.mkdtemp())
    print(f"mrcal {getattr(mrcal, '__version__', '')}: largest differences")
    for name, found in (("corners.vnl", corners(seen)), (".cameramodel", cameramodel(seen))):
        print(f"  {name:13} pixels {found[0]:.1e}, target {found[1]:.1e}, weights {found[2]:.1e}")
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, 9), np.linspace(-0.4, 0.4, 7))
    rays = np.column_stack([x.ravel(), y.ravel(), np.ones(x.size)])
    for name, lens in LENSES.items():
        k = np.array([K[one] for one in lens.names])
        given = FittedCamera.from_arrays(lens, INTRINSICS, k, (640, 480))
        bc.save_camera(given, "c.cameramodel", "mrcal", force=True)
        theirs = mrcal.project(rays, *mrcal.cameramodel("c.cameramodel").intrinsics())
        gap = np.abs(theirs - Camera(lens).pixels(INTRINSICS, k, rays)).max()
        print(f"  {name:13} projection {gap:.1e} px")


if __name__ == "__main__":
    main()
