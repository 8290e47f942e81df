"""Recordings and simulated dives that response tables are learnt from, and their counting.

Frames count once more made harder: the cable fainter, the picture blurred and in noise.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import cv2
import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.cable.learning.response_counts import ResponseCounts
from cable_tracker.cable.measure.picture.working_image import working_image_for
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.errors import FrameError, ParameterError, RecordingError
from cable_tracker.evaluation.evaluation_sequences import (
    SimulatedSequence,
    WorldSequence,
    available_sequences,
)
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.source_base import Source
from cable_tracker.simulation.rendering.texture import in_rows, smooth_step
from cable_tracker.simulation.worlds.catalogue import WORLDS, Split
from cable_tracker.simulation.worlds.strip import pixel_grid, view_strip
from cable_tracker.tracking.image_frame import image_centre
from cable_tracker.tracking.parameter_table import REFERENCE_WIDTH
from cable_tracker.tracking.succession import check_frame

FAINTEST = 0.1
"""Smallest share of its contrast that a faded cable keeps."""

MOST_BLUR = 1.5
"""Largest standard deviation of the added blur [px at 320 px]."""

MOST_NOISE = 0.05
"""Largest standard deviation of the added noise, over the range of the picture's grey levels."""

SEAM = 0.25
"""Half width of the middle, where the surroundings of both sides are blended [radii]."""

MARGIN = 0.15
"""Distance beyond the border within which the cable's edge ends [radii]."""

ROW = 512
"""Pixels of a cable are gathered into rows of this length."""


@dataclass(frozen=True, slots=True, eq=False)
class LabelledSequence:
    """Something to learn from.

    Attributes
    ----------
    name : str
        Name in messages to the user.
    frame_count : int or None
        Number of frames; None when it is unknown before all have been read.
    frames : callable
        Makes or reads them. A frame in which nothing of the cable can be seen has no truth.
    unlabelled_is_empty : bool
        Whether a frame without a truth shows no cable, and so is background. Otherwise it is passed
        over.
    """

    name: str
    frame_count: int | None
    frames: Callable[[], Iterator[Frame]]
    unlabelled_is_empty: bool = False


@dataclass(frozen=True, slots=True)
class LearningPlan:
    """Plan for counting frames.

    Attributes
    ----------
    every : int
        Interval of the frames that are used, from the first.
    harder : int
        Number of harder copies of each frame that are counted, too, see `made_harder`.
    limit : int or None
        Number of frames used from the beginning of each simulated dive; None: all.
    skip_bad_frames : bool
        Pass over a frame that cannot be decoded.
    unlabelled_is_empty : bool
        Whether frames of recordings without a label show no cable.
    """

    every: int = 1
    harder: int = 1
    limit: int | None = None
    skip_bad_frames: bool = False
    unlabelled_is_empty: bool = False


def simulated_dives(
    names: Sequence[str], seeds: Sequence[int], limit: int | None
) -> tuple[list[LabelledSequence], dict[str, str]]:
    """Return dives to learn from: each of some scenarios and worlds with each seed.

    Worlds of a pattern that cannot be drawn here come second, each with the reason.

    Parameters
    ----------
    names : sequence of str
        Names of scenarios and of worlds to tune on, or patterns of them such as "tune_*".
    seeds : sequence of int
        Seeds; each makes another dive.
    limit : int or None
        Number of frames used from the beginning of each; None: all.

    Raises
    ------
    ParameterError
        There is no such scenario, or it is a world that reports are made on.
    RecordingError
        A world that is named needs photographs, and there are none.
    """
    dives: list[LabelledSequence] = []
    sequences, left_out = available_sequences(names, limit) if names else ((), {})
    for sequence in sequences:
        world = WORLDS[sequence.name] if isinstance(sequence, WorldSequence) else None
        if world is not None and world.split is Split.REPORT:
            raise ParameterError(
                f"scenario: {world.name} is a world to report on, which nothing may be learnt from;"
                " take worlds whose names begin with tune_"
            )
        count, is_empty = sequence.frame_count(), world is not None and not world.has_cable
        for seed in seeds:
            name = f"{sequence.name}, seed {seed}"
            frames = partial(_learnable, sequence, seed)
            dives.append(LabelledSequence(name, count, frames, is_empty))
    return dives, left_out


def _learnable(sequence: SimulatedSequence, seed: int) -> Iterator[Frame]:
    for item in sequence.simulated(seed):
        # Where a person would hardly see the cable there is nothing to learn.
        yield item.frame if item.visibility > 0.0 else replace(item.frame, truth=None)


def labelled_recording(recording: Source, plan: LearningPlan) -> LabelledSequence:
    """Return an open recording to learn from.

    Raises
    ------
    RecordingError
        It has no labels, and was not said to show no cable.
    """
    if not (recording.has_truth or plan.unlabelled_is_empty):
        raise RecordingError(
            f"{recording.path}: has no ground truth to learn from; give labels with --truth FILE"
        )
    return LabelledSequence(
        str(recording.path), recording.frame_count, recording.frames, plan.unlabelled_is_empty
    )


class FrameCounter:
    """Counts responses of the border filter in labelled frames, as the tracker sees them.

    Parameters
    ----------
    parameters : TrackerParameters
        Parameters that the table will be used with; their seed draws where background is counted,
        and how much harder frames are made.
    plan : LearningPlan
        Selection of the frames that are counted.

    Attributes
    ----------
    counts : ResponseCounts
        The responses so far.
    recorded : int
        Number of labelled frames that were counted as they are.
    harder : int
        Number of harder copies of them.
    """

    def __init__(self, parameters: TrackerParameters, plan: LearningPlan) -> None:
        elsewhere, self._rng = np.random.default_rng(parameters.seed).spawn(2)
        self.counts = ResponseCounts(elsewhere)
        self.recorded = self.harder = 0
        self._parameters, self._plan = parameters, plan

    def describe(self) -> str:
        """Describe how many frames have been counted."""
        copies = f" and {self.harder} harder copies of them" if self.harder else ""
        return f"{self.recorded} frames{copies}"

    def count(self, sequence: LabelledSequence, frames: Iterable[Frame]) -> None:
        """Count the labelled and the empty frames of a sequence, every K-th of `frames`.

        Raises
        ------
        FrameError
            A frame cannot be used and is not to be skipped.
        """
        for frame in frames:
            is_empty = frame.truth is None
            if frame.index % self._plan.every or (is_empty and not sequence.unlabelled_is_empty):
                continue
            try:
                image = decode_grey(frame.image)
                check_frame(image)
            except FrameError as error:
                if self._plan.skip_bad_frames:
                    continue
                raise FrameError(f"{sequence.name}: frame {frame.index}: {error}") from error
            if frame.truth is None:
                self.counts.add_background(working_image_for(image, self._parameters))
            else:
                self._count_labelled(image, frame.truth)

    def _count_labelled(self, image: Image, truth: CableState) -> None:
        polarity = self.counts.add(working_image_for(image, self._parameters), truth)
        if polarity is None:
            return
        self.recorded += 1
        for _ in range(self._plan.harder):
            harder = working_image_for(made_harder(image, truth, self._rng), self._parameters)
            self.harder += self.counts.add(harder, truth, polarity) is not None


def describe_origin(
    scenarios: Sequence[str],
    seeds: Sequence[int],
    paths: Sequence[Path],
    truth: Path | None,
    plan: LearningPlan,
    *,
    left_out: Iterable[str] = (),
) -> str:
    """Say what a table is learnt from, without the folders, which are private.

    `left_out` are the worlds that a pattern among the scenarios stands for, but for want of
    photographs.
    """
    parts = []
    if scenarios:
        word = "seed" if len(seeds) == 1 else "seeds"
        numbers = ", ".join(map(str, seeds))
        beginning = f", {plan.limit} frames of each" if plan.limit is not None else ""
        missing = ", ".join(left_out)
        without = f" without {missing}" if missing else ""
        parts.append(f"simulated {', '.join(scenarios)}{without} with {word} {numbers}{beginning}")
    parts += [path.resolve().name for path in paths]
    if truth is not None:
        parts[-1] += f" labelled by {truth.name}"
    if plan.unlabelled_is_empty:
        parts.append("frames without a label as background")
    if plan.every > 1:
        parts.append(f"one frame in {plan.every}")
    if plan.harder > 0:
        times = "" if plan.harder == 1 else f", {plan.harder} times"
        parts.append(f"as they are and with the cable faded, blurred and in noise{times}")
    return "; ".join(parts)


def faded(picture: Image, cable: CableState, share: float) -> Image:
    """Return a picture in which a cable keeps only a share of its contrast.

    The bottom under the cable is filled in by what lies beside it, mirrored at the border: both
    meet there without an edge.

    Parameters
    ----------
    picture : Image
        Grey levels, shape (H, W).
    cable : CableState
        State of the cable [px, rad].
    share : float
        0: removed; 1: unchanged.

    Returns
    -------
    Image
        float32, shape (H, W).
    """
    values = np.asarray(picture, np.float32)
    height, width = values.shape
    x, y = pixel_grid((width, height))
    view = view_strip(cable.to_array(), x, y)
    found = np.flatnonzero(np.abs(view.u) < 1 + MARGIN)
    result = values.copy()
    if found.size == 0:
        return result
    inside = in_rows(found, ROW)
    u, v, radius = (each.reshape(-1)[inside] for each in (view.u, view.v, view.radius))
    along = v * radius
    left, right = (
        _sampled(values, cable, (side * (2 + 2 * MARGIN) - u) * radius, along)
        for side in (-1.0, 1.0)
    )
    beside = left + smooth_step(u, -SEAM, SEAM) * (right - left)
    flat = result.reshape(-1)
    flat[inside] = beside + np.float32(share) * (flat[inside] - beside)
    return result


def _sampled(values: Image, cable: CableState, across: Image, along: Image) -> Image:
    """Return the picture sampled at places across and along a cable, from its foot point [px]."""
    column, row = image_centre((values.shape[1], values.shape[0]))
    cos, sin = np.float32(np.cos(cable.angle)), np.float32(np.sin(cable.angle))
    across = across + np.float32(cable.distance)
    columns = across * cos - along * sin + np.float32(column)
    rows = np.float32(row) - across * sin - along * cos
    return cv2.remap(
        values,
        columns.astype(np.float32),
        rows.astype(np.float32),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_REFLECT_101,
    )


def made_harder(picture: Image, cable: CableState, rng: np.random.Generator) -> Image:
    """Return a picture with the cable faded to 10^-U(0, 1), blurred and with noise added.

    Parameters
    ----------
    picture : Image
        Grey levels, uint8 or float32, shape (H, W).
    cable : CableState
        State of the cable [px, rad].
    rng : numpy.random.Generator
        Draws contrast, blur and noise.

    Returns
    -------
    Image
        float32, shape (H, W); of a uint8 picture, whole numbers from 0 to 255.
    """
    share = FAINTEST ** float(rng.random())
    blur = MOST_BLUR * float(rng.random()) * picture.shape[1] / REFERENCE_WIDTH
    low, high = np.percentile(picture, (2, 98))
    noise = MOST_NOISE * float(rng.random()) * float(high - low)
    values = faded(picture, cable, share)
    if blur > 0.1:
        values = cv2.GaussianBlur(values, (0, 0), blur)
    grain: Image = rng.standard_normal(values.shape, np.float32)
    values = values + np.float32(noise) * grain
    return np.clip(np.rint(values), 0.0, 255.0) if picture.dtype == np.uint8 else values
