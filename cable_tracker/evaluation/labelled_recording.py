"""A recording of the user's that methods are judged on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from cable_tracker.arrays import Image
from cable_tracker.errors import FrameError, RecordingError
from cable_tracker.sequences.frame import CompressedImage, Frame, RawImage
from cable_tracker.sequences.recording_files import recording_files
from cable_tracker.sequences.source_base import ChosenRecording


@dataclass(frozen=True, slots=True)
class LabelledRecording(ChosenRecording):
    """A recording with labels, the same for every seed.

    Attributes
    ----------
    unlabelled_is_empty : bool
        Whether a frame without a label shows nothing to track. Otherwise it is not judged.
    """

    unlabelled_is_empty: bool = field(default=False, kw_only=True)

    @property
    def name(self) -> str:
        """The name of the file or folder."""
        return self.path.resolve().name

    def decoded(
        self, frame: Frame, decode: Callable[[RawImage | CompressedImage], Image]
    ) -> Image | None:
        """Return the pixels of a frame; None for a bad one where such frames are left out.

        Raises
        ------
        RecordingError
            It cannot be decoded, and the user did not ask to go on.
        """
        try:
            return decode(frame.image)
        except FrameError as error:
            if self.skip_bad_frames:
                return None
            raise RecordingError(
                f"{self.path}: frame {frame.index} cannot be decoded ({error});"
                " --skip-bad-frames leaves such frames out"
            ) from error

    def files(self) -> list[Path]:
        """Return the paths that it is read from: files or a folder, and the labels."""
        labels = [] if self.truth is None else [self.truth]
        return [*recording_files(self.path), *labels]
