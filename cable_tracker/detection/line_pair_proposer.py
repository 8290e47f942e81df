"""Line pairs of a whole frame, fast enough for every frame of a tracker.

A coarse Hough transform over the gradients that the tracker has worked out anyway. Each strong
gradient votes near its own direction over the full turn, so that the two borders of a cable have
opposite normals. What comes out is a proposal: coarse, often wrong, seldom without the cable.

The constants were chosen on simulated dives of the seeds 200 to 203.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.cable.measure.scanned_gradients import Channel, ScanLines
from cable_tracker.cable.measure.working_image import WorkingImage
from cable_tracker.cable.model.state import PLACES, StateColumn
from cable_tracker.detection.border_lines import BorderLines
from cable_tracker.detection.line_pairs import states_of_pairs

STRONG = 2.0
"""Weaker gradients do not vote [robust scales]."""

VOTE_CAP = 5.0
"""No gradient votes with more: a glint must not outweigh a long border [robust scales]."""

ANGLE_BINS = 120
"""Bins of the accumulator over a full turn."""

ANGLE_MARGIN = 2
"""The angle goes round: so many bins of the other end let peaks at the seam be seen whole."""

NEIGHBOURHOOD = np.ones((5, 3), np.uint8)
"""Bins of angle and offset in which a peak is the highest."""

OFFSET_BIN = 3.0
"""Width of a bin of the accumulator [px at the reference width]."""

VOTE_SPREAD = 2
"""Bins to either side of the gradient's direction that it votes for."""

MOST_LINES = 16
MOST_CABLES = 6
NARROWEST, WIDEST = 10.0, 130.0
"""w of a pair [px at the reference width]."""

MOST_SKEW = float(np.deg2rad(15.0))


@dataclass(frozen=True, slots=True, eq=False)
class Voters:
    """Strong gradients of a picture.

    Attributes
    ----------
    x, y : FloatArray
        Where, in the image frame of the working picture [px], shape (P,).
    directions : FloatArray
        Where it gets brighter [rad], counter-clockwise from +x, shape (P,).
    weights : FloatArray
        Of their votes, shape (P,).
    """

    x: FloatArray
    y: FloatArray
    directions: FloatArray
    weights: FloatArray


class LinePairProposer:
    """Propose cables where two lines of opposite contrast are nearly parallel."""

    def propose(self, image: WorkingImage) -> FloatArray:
        """Return d, alpha, w, beta of cables in the frame [px, rad], best first, shape (K, 4)."""
        voters = strong_gradients(image)
        if not len(voters.weights):
            return np.empty((0, PLACES))
        lines = strongest_lines(voters, image)
        first, second = (np.asarray(index, np.int64) for index in np.triu_indices(len(lines), k=1))
        states = states_of_pairs(lines, first, second)[:, :PLACES]
        chosen = _best_pairs(states, lines, first, second, image.scale)
        scale = 1.0 / image.reduction
        return np.asarray(states[chosen] * np.array([scale, 1.0, scale, 1.0]))


def strong_gradients(image: WorkingImage) -> Voters:
    """Return the ridges of the gradient along the scan lines of a frame."""
    rows, columns = image.scanned.rows, image.scanned.columns
    u, v, along, across = _ridges(rows)
    v_turned, u_turned, across_turned, along_turned = _ridges(columns)
    # Rows are scanned along x, columns along y.
    x, y = np.concatenate((u, u_turned)), np.concatenate((v, v_turned))
    gradient_x = np.concatenate((along, along_turned))
    gradient_y = np.concatenate((across, across_turned))
    return Voters(
        x=x,
        y=y,
        directions=np.arctan2(gradient_y, gradient_x),
        weights=np.minimum(np.hypot(gradient_x, gradient_y), VOTE_CAP),
    )


def _ridges(lines: ScanLines) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return u, v and the gradient along both where it is strong, highest, and along the line."""
    along = lines.gradients[..., Channel.ALONG]
    across = lines.gradients[..., Channel.ACROSS]
    squared = along**2 + across**2
    inner = squared[:, 1:-1]
    highest = (inner >= squared[:, :-2]) & (inner > squared[:, 2:]) & (inner > STRONG**2)
    line, place = np.nonzero(highest & (np.abs(along) >= np.abs(across))[:, 1:-1])
    place = place + 1
    return (
        place - (along.shape[1] - 1) / 2,
        lines.places[line],
        along[line, place].astype(np.float64),
        across[line, place].astype(np.float64),
    )


def accumulator_layout(image: WorkingImage) -> tuple[float, int]:
    """Return the width of a bin of offsets [px], and the number of the bin of offset zero."""
    offset_bin = max(OFFSET_BIN * image.scale, 1.0)
    return offset_bin, int(np.hypot(*image.size) / 2 / offset_bin) + 2


def strongest_lines(voters: Voters, image: WorkingImage) -> BorderLines:
    """Return the lines that get most votes, best first; `supports` are the votes."""
    offset_bin, middle = accumulator_layout(image)
    votes = _vote(voters, offset_bin, middle)
    margin = ANGLE_MARGIN
    padded = np.pad(votes, ((margin, margin), (0, 0)), mode="wrap").astype(np.float32)
    smooth = cv2.GaussianBlur(padded, (3, 3), 0)
    highest = cv2.dilate(smooth, NEIGHBOURHOOD)
    peaks = ((smooth >= highest) & (smooth > 0))[margin:-margin]
    rows, columns = np.nonzero(peaks)
    heights = smooth[margin:-margin][rows, columns]
    order = np.argsort(-heights, kind="stable")[:MOST_LINES]
    return BorderLines(
        angles=rows[order].astype(np.float64) * (2 * np.pi / ANGLE_BINS),
        offsets=(columns[order] - middle).astype(np.float64) * offset_bin,
        supports=heights[order].astype(np.float64),
    )


def _vote(voters: Voters, offset_bin: float, middle: int) -> FloatArray:
    directions = np.arange(ANGLE_BINS) * (2 * np.pi / ANGLE_BINS)
    cos, sin = np.cos(directions), np.sin(directions)
    nearest = np.rint(voters.directions * (ANGLE_BINS / (2 * np.pi))).astype(np.int64)
    bins = (nearest[:, None] + np.arange(-VOTE_SPREAD, VOTE_SPREAD + 1)) % ANGLE_BINS
    offsets = voters.x[:, None] * cos[bins] + voters.y[:, None] * sin[bins]
    columns = np.rint(offsets / offset_bin).astype(np.int64) + middle
    count = 2 * middle + 1
    weights = np.repeat(voters.weights, bins.shape[1])
    cells = (bins * count + columns).ravel()
    votes = np.bincount(cells, weights, minlength=ANGLE_BINS * count)
    return votes.reshape(ANGLE_BINS, count).astype(np.float64)


def _best_pairs(
    states: FloatArray,
    lines: BorderLines,
    first: IndexArray,
    second: IndexArray,
    scale: float,
) -> IndexArray:
    """Return which pairs are plausible cables, best first; both borders must have votes."""
    width = states[:, StateColumn.WIDTH]
    plausible = (
        (width >= NARROWEST * scale)
        & (width <= WIDEST * scale)
        & (np.abs(states[:, StateColumn.SKEW]) <= MOST_SKEW)
    )
    scores = np.where(plausible, lines.supports[first] * lines.supports[second], -1.0)
    order = np.argsort(-scores, kind="stable")[:MOST_CABLES]
    best: IndexArray = order[scores[order] > 0.0]
    return best
