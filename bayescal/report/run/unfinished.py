"""What an unfinished run keeps: what took long, as soon as it is done, so that it goes on.

``about.json``     what was asked for, of which points, by which versions
``NAME.nc``        draws of one model, as a run has them (NetCDF, that is HDF5)
``NAME.npz``       what else took long, such as a lens's fit, or its evidence
"""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bayescal.comparison.key import Key
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from bayescal.encoding import Encoded, encoded
from bayescal.files import make_folder, write_whole
from bayescal.inference.arviz_bridge import netcdf_bytes, parse_netcdf
from bayescal.inference.checked_posterior import CheckedPosterior
from bayescal.inference.sampled_model import SampledModel
from bayescal.inference.stored import packed, unpacked
from bayescal.linear.model import LinearModel
from bayescal.points.correspondences import Correspondences
from bayescal.points.views.views import Views
from bayescal.points.views.writer import views_to_csv
from bayescal.report.document.shared import versions
from bayescal.report.run.folder import digest

if TYPE_CHECKING:
    from bayescal.comparison.store import Kept

ABOUT = "about.json"


class Unfinished(Store):
    """Keeps what was sampled in a folder as it is made, and takes it from there.

    The same draws come out as without a break: every model has random numbers of its own, and
    one that was not finished is sampled from its beginning.

    Parameters
    ----------
    folder : Path
        What it holds of another request, other points or other versions is removed.
    of : Correspondences or Views
        What is analysed.
    request : Any
        What else was asked for.
    """

    def __init__(
        self, folder: Path, of: Correspondences | Views, settings: Settings, request: object
    ) -> None:
        super().__init__()
        self.folder = folder
        facts = [asdict(settings), repr(request), *_identity(of), versions()]
        self._about = json.dumps(facts).encode()
        if self._raw(ABOUT) not in (None, self._about):
            clear(folder)

    def read(self, key: Key, model: LinearModel | SampledModel, *, beside: bool) -> Kept | None:  # noqa: ARG002
        """Read the draws of a model; None where it was not finished, or has a closed form."""
        raw = None if isinstance(model, LinearModel) else self._raw(f"{key.file()}.nc")
        return None if raw is None else unpacked(parse_netcdf(raw), model)

    def made(self, key: Key, found: Kept) -> None:
        """Keep the draws of a model that was sampled without a closed form."""
        if not isinstance(found, CheckedPosterior):
            self._keep(f"{key.file()}.nc", netcdf_bytes(packed(found)))

    def known(self, name: str, kind: Any) -> tuple[Any] | None:
        """Read a value that took long."""
        raw = self._raw(f"{name}.npz")
        return None if raw is None else (Encoded.parse(raw).value(name, kind),)

    def noted(self, name: str, value: Any) -> None:
        """Keep a value that took long."""
        self._keep(f"{name}.npz", encoded({name: value}))

    def _raw(self, name: str) -> bytes | None:
        place = self.folder / name
        return place.read_bytes() if place.is_file() else None

    def _keep(self, name: str, raw: bytes) -> None:
        if not (self.folder / ABOUT).is_file():
            make_folder(self.folder)
            write_whole(self.folder / ABOUT, self._about)
        write_whole(self.folder / name, raw, force=True)


def _identity(of: Correspondences | Views) -> tuple[str, str]:
    """Tell points from others, or views."""
    if isinstance(of, Views):  # some of a file's may be left out
        return digest(views_to_csv(of).encode()), ""
    return of.sha256, repr(of.setup)


def kept_in(folder: Path) -> int:
    """Count the models that an unfinished run kept: sampled ones, and lenses that are judged."""
    kept = [place.stem for kind in ("*.nc", "* evidence.npz") for place in folder.glob(kind)]
    return len({name.removesuffix(" evidence") for name in kept})


def clear(folder: Path) -> None:
    """Remove what an unfinished run kept, and nothing else."""
    if not (folder / ABOUT).is_file():
        return
    for place in (*folder.glob("*.nc"), *folder.glob("*.npz"), *folder.glob(".bayescal-*")):
        place.unlink()
    (folder / ABOUT).unlink()
    folder.rmdir()
