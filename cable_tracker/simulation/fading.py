"""Pictures of a labelled cable made harder: the cable fainter, the picture blurred and in noise."""

from __future__ import annotations

import cv2
import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.cable.model.state import CableState
from cable_tracker.simulation.rendering.texture import in_rows, smooth_step
from cable_tracker.simulation.worlds.strip import pixel_grid, view_strip
from cable_tracker.tracking.image_frame import image_centre
from cable_tracker.tracking.parameter_table import REFERENCE_WIDTH

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
