"""Learns pixels, shape and appearance of a target from the frame in which it was marked."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray
from cable_tracker.target.measure.appearance import Appearance, learn_appearance
from cable_tracker.target.measure.features import bins_of, choose_bins, looked_up
from cable_tracker.target.measure.outline import contour_settings, find_outline
from cable_tracker.target.measure.region import HueModel, score_poses
from cable_tracker.target.measure.working_frame import WorkingFrame
from cable_tracker.target.model.state import STATE_SIZE
from cable_tracker.target.model.template import LEAST_AREA, Template, centroid, template_of_mask
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.tracking.image_frame import bounding_box

ROUNDS = 3
"""Iterations of outline and appearance in turn."""

BOX_SOFTNESS = 0.15
"""Softness of the ellipse in a box as a prior of shape, in roots of its area."""

BOX_ERROR = 0.15
"""Largest distance of a target's outline beyond the box that marks it, in sides of the box."""


class FirstLook(NamedTuple):
    """Shape, appearance and pose of a target in the frame in which it was marked.

    Attributes
    ----------
    template : Template
        Shape.
    appearance : Appearance
        Colours or greys and texture.
    state : FloatArray
        Pose, shape (6,).
    score : float
        Mean log-ratio in the region there less that around.
    """

    template: Template
    appearance: Appearance
    state: FloatArray
    score: float


def learn_target(
    frame: WorkingFrame, mask: BoolArray, parameters: TargetParameters, *, is_exact: bool
) -> FirstLook:
    """Learn a target from the frame in which it was marked.

    Parameters
    ----------
    mask : BoolArray
        Marked pixels, shape (H, W).
    is_exact : bool
        Whether the mask is the target's own; else it is that of a box, and is refined.

    Raises
    ------
    FrameError
        The mask is too small.
    """
    points, limit = parameters.template_points, parameters.ratio_limit
    settings = contour_settings(parameters)
    bins = choose_bins(frame.channels, frame.is_coloured)
    bin_map = bins_of(frame.channels, bins.lookups)
    marked = template_of_mask(mask, points, frame.zoom)
    state = np.zeros(STATE_SIZE)
    state[:2] = centroid(mask)
    appearance = learn_appearance(bin_map, mask, bins)
    allowed = _widened(mask)
    for _ in range(0 if is_exact else ROUNDS):
        ratios = looked_up(bin_map, appearance.log_ratios(limit))
        outline = find_outline(ratios, state, marked, BOX_SOFTNESS, settings)
        if outline is None:
            break
        found = outline.in_picture(frame.shape) & allowed
        if found.sum() < max(LEAST_AREA, 0.15 * mask.sum()):
            break
        appearance = learn_appearance(bin_map, found, bins)
        mask = found
    template = template_of_mask(mask, points, frame.zoom)
    state = np.zeros(STATE_SIZE)
    state[:2] = centroid(mask)
    ratios = looked_up(bin_map, appearance.log_ratios(limit))
    plain = HueModel(bin_map, appearance.hue_roots(), 0.0)
    scores = score_poses(
        ratios, state[None], template.inside, template.around, template.size, plain
    )
    return FirstLook(template, appearance, state, float(scores[0]))


def _widened(mask: BoolArray) -> BoolArray:
    """Return the box around a mask that is not empty, with a margin of `BOX_ERROR`, as a mask."""
    box = bounding_box(mask)
    assert box is not None
    left, top, right, bottom = box
    across = int(BOX_ERROR * (right - left)) + 1
    down = int(BOX_ERROR * (bottom - top)) + 1
    widened = np.zeros_like(mask)
    widened[max(top - down, 0) : bottom + down, max(left - across, 0) : right + across] = True
    return widened
