"""A kind of result: what it must say of itself, and what follows for every kind alike."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar

from bayescal.comparison.faces.convert import Converts
from bayescal.comparison.settings import Settings
from bayescal.errors import InputError
from bayescal.files import FolderKind, check_folder, write_folder
from bayescal.inference.arviz_bridge import Draws
from bayescal.points.setup_file import to_toml
from bayescal.points.writer import to_csv
from bayescal.report.blocks import Blocks
from bayescal.report.document.shared import dumps
from bayescal.report.run.bounded import CAMERA
from bayescal.report.run.covariance import COVARIANCE, covariance_csv
from bayescal.report.run.files import RunFiles
from bayescal.report.run.folder import POINTS, RUN, SETUP, fill_run
from bayescal.report.run.shape import disagreement
from bayescal.report.views.views import Views

if TYPE_CHECKING:  # what is printed alone does not pay for a camera
    from bayescal.prediction.calibrated.camera import CalibratedCamera

Result = TypeVar("Result")


class Kind(ABC, Generic[Result]):
    """A kind of result that can be written to a folder."""

    folder: ClassVar[FolderKind] = RUN

    @abstractmethod
    def document(self, result: Result, command: str) -> dict[str, Any]:
        """Build its document; `command` is how it was asked for."""

    @abstractmethod
    def fill(self, folder: Path, result: Result) -> None:
        """Write what belongs beside the document."""

    @abstractmethod
    def view(self, result: Result, *, full: bool = False) -> Blocks:
        """Give what its command prints, or everything there is to say."""

    def text(self, result: Result, command: str) -> str:
        """Its document as text."""
        return dumps(self.document(result, command))

    def check(self, folder: Path, *, force: bool) -> None:
        """Refuse, before any work is done, a place where the folder can't be put.

        Raises
        ------
        OutputError
        """
        check_folder(folder, self.folder, force=force)

    def write(self, folder: Path, result: Result, text: str, *, force: bool) -> None:
        """Write the folder, whole or not at all.

        Parameters
        ----------
        text : str
            Its document's.
        force : bool
            Replace an earlier folder of the kind.

        Raises
        ------
        OutputError
            Where it can't be written; nothing is left behind.
        """

        def fill(made: Path) -> None:
            (made / self.folder.marker).write_bytes(text.encode())
            self.fill(made, result)

        write_folder(folder, self.folder, fill, force=force)


class RunKind(Kind[Result]):
    """A kind of result whose folder is a run: it can be taken up again.

    Attributes
    ----------
    result : type
        Of its values.
    name : str
        In a word, for messages.
    element : str
        Name under which a page keeps its document.
    views : Views
        How it is shown.
    schema : str
        That its document names.
    made_by : str
        The command that writes its runs.
    shape : Any
        What its document must hold, and which numbers must come out the same
        (`bayescal.report.run.shape`).
    beside : frozenset of str
        Keys of the document's settings that are none of `Settings`.
    defended : bool
        Whether it may answer a referee.
    """

    result: ClassVar[type]
    name: ClassVar[str]
    element: ClassVar[str]
    views: ClassVar[Views[Any]]
    schema: ClassVar[str]
    made_by: ClassVar[str]
    shape: ClassVar[Any]
    beside: ClassVar[frozenset[str]] = frozenset()
    defended: ClassVar[bool] = False

    def checked(self, result: Result) -> dict[str, Any]:
        """Build what of its document a reopened run is checked by: all, unless that takes long."""
        return self.document(result, "")

    @abstractmethod
    def models(self, result: Result) -> Mapping[str, Converts]:
        """Its models whose parameters are known, by their names in a run."""

    @abstractmethod
    def draws(self, result: Result) -> Mapping[str, Draws]:
        """Draws to keep, by the model's name."""

    @abstractmethod
    def reopen(self, run: RunFiles, settings: Settings) -> Result:
        """Take a result up again from its document and draws.

        Nothing is sampled. What follows from points and draws is computed again; it is compared
        with the document by whoever calls.

        Raises
        ------
        InputError
            Where what was asked for is not usable here.
        """

    def camera(self, result: Result) -> CalibratedCamera:
        """Make the calibrated camera of a result.

        Raises
        ------
        InputError
            Where it holds none.
        """
        from bayescal.prediction.calibrated.camera import no_camera

        raise no_camera(result)

    def view(self, result: Result, *, full: bool = False) -> Blocks:
        """Give what its command prints, or everything there is to say."""
        return self.views.full(result) if full else self.views.brief(result)

    def pictures(self, folder: Path, result: Result) -> None:
        """Add pictures, which nothing is read from."""

    def read(self, result: Result) -> Any:
        """Give what the result is of, as it was read: its points."""
        points = getattr(result, "points", None)
        if points is None:
            raise InputError(
                f"a run holds world points and pixels; this {self.name} is of plain arrays"
            )
        return points

    def files(self, result: Result) -> dict[str, bytes]:
        """Give the files, by their names, that hold what the result is of."""
        points = self.read(result)
        return {POINTS: to_csv(points).encode(), SETUP: to_toml(points.setup).encode()}

    def fill(self, folder: Path, result: Result) -> None:
        """Write what the result is of, camera, draws and their hashes, and pictures."""
        from bayescal.prediction.calibrated.saved import camera_bytes

        files = self.files(result)
        files[COVARIANCE] = covariance_csv(self.models(result)).encode()
        with suppress(InputError):  # it may hold no camera
            files[CAMERA] = camera_bytes(self.camera(result))
        derived = getattr(result, "derived", {})
        fill_run(folder, files, self.draws(result), derived, self.read(result))
        self.pictures(folder, result)

    def open(self, folder: Path, *, defend: bool | None = None) -> Result:
        """Read a result back from its run.

        Parameters
        ----------
        defend : bool, optional
            Whether to answer a referee too; by default where the run does.

        Raises
        ------
        InputError
            As `bayescal.open_run`.
        """
        run = RunFiles.at(folder, self.schema, self.made_by, self.shape)
        if defend is not None and not self.defended:
            raise InputError(f"{folder}: is no comparison, which alone is defended")
        asked = run.settings(self.beside)
        settings = asked if defend is None else replace(asked, defend=defend)
        try:
            found = self.reopen(run, settings)
        except InputError as error:
            raise error if str(error).startswith(str(folder)) else run.unusable(error) from None
        wrong = disagreement(run.document, self.checked(found), self.shape)
        if wrong is not None:
            raise InputError(f"{folder}: {wrong}: {run.between()}; {run.again}")
        # With other answers than the run's it is no longer what the run holds.
        origin = run.document["provenance"] if settings == asked else None
        value: Any = found  # a dataclass
        again: Result = replace(value, origin=origin)
        return again
