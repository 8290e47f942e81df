"""Whether the leading hypothesis is fixed to the vehicle: it stands still while the ground moves.

The shadow of a vehicle's frame, a beam of light or a part of the vehicle itself looks like a cable
in each single picture. But a cable moves with the ground it lies on. Every `LOOK_INTERVAL` a patch
of the ground to either side of the hypothesis, or to the one where there is room, is held against
the same place in the last look: the phase of their cross-power spectrum tells the shift. Ground
without texture, or two patches too far apart, give a peak that is too low, and nothing is told.

How far the ground has moved across the hypothesis is held against how far that has moved. Ground
that moves along it, as below a vehicle that follows a cable, tells nothing. In perspective such
ground moves along lines through the point at which the borders meet; ground that still moves to one
side here and to the other there tells nothing, either.

What was once found to be a fixture is one wherever it comes back, until it moves with the ground.

References
----------
C. D. Kuglin and D. C. Hines (1975), "The phase correlation image alignment method".
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import NamedTuple

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.measure.picture.working_image import WorkingImage
from cable_tracker.cable.model.geometry import foot_point, middle_inside, states_in_chart
from cable_tracker.cable.model.state import (
    ANGLE,
    DISTANCE,
    POSE_SIZE,
    STATE_SIZE,
    WIDTH,
    pose_units,
)

SIDE = 64
"""Side of a patch [px at the reference width]."""

CLEAR_OF_STRIP = 2.0
"""Distance between the strip and a patch [px at the reference width]."""

LEAST_BESIDE = 0.25
"""Where the edge of the picture pushes a patch over the strip, its centre lies so far outside of
the border at least [sides of a patch]."""

LEAST_RESPONSE = 0.4
"""Height of the peak from which on a shift is believed; 1 for the same picture."""

LARGEST_SHIFT = 0.25
"""Of a larger shift too little of the ground is in both pictures [sides of a patch]."""

LOOK_INTERVAL = 0.15
"""Time between two looks at the ground [s]."""

KEPT = 0.8
"""Share of what was travelled before that counts after one more look."""

FEWEST_LOOKS = 3
"""Looks after which a hypothesis may be taken for a fixture."""

STILL, MOVING = 0.25, 0.5
"""Travel of a strip across itself as a share of that of the ground: up to the first it stands
still, unless it goes to and fro; from the second on it moves with the ground."""

LEAST_ACROSS = 0.25
"""Share of the ground's travel that leads across a fixture, at least."""


class GroundPatches(NamedTuple):
    """Patches of a picture to either side of a strip.

    Attributes
    ----------
    shape : tuple of int
        Height and width of the picture [px].
    corners : tuple of (int, int)
        Column and row of their first pixel, the left side of the strip first [px]; one beside a
        strip at the edge of the picture, else two.
    patches : tuple of Image
        Grey levels, float32, square.
    """

    shape: tuple[int, ...]
    corners: tuple[tuple[int, int], ...]
    patches: tuple[Image, ...]

    def centres(self) -> FloatArray:
        """Return the centres of the patches in the image frame, shape (K, 2) [px]."""
        side = len(self.patches[0])
        return np.array([_centre(corner, side, self.shape) for corner in self.corners])


def patches_beside(pose: FloatArray, picture: Image, scale: float) -> GroundPatches | None:
    """Return the patches beside a strip; None where the picture has no room on either side.

    Parameters
    ----------
    pose : FloatArray
        d, alpha, w and more of the strip [px of the picture, rad].
    picture : Image
        Grey levels, float32, shape (h, w).
    scale : float
        Pixels of the picture per pixel of one of the reference width.
    """
    height, width = picture.shape
    side = round(SIDE * scale)
    middle = middle_inside(float(pose[ANGLE]), float(pose[DISTANCE]), (width, height))
    if middle is None or side > min(width, height):
        return None
    normal = np.array([np.cos(pose[ANGLE]), np.sin(pose[ANGLE])])
    corners = []
    for outwards in (-normal, normal):
        centre = middle + (0.5 * (pose[WIDTH] + side) + CLEAR_OF_STRIP * scale) * outwards
        column = min(max(round(centre[0] + 0.5 * (width - side)), 0), width - side)
        row = min(max(round(0.5 * (height - side) - centre[1]), 0), height - side)
        inside = _centre((column, row), side, picture.shape)
        if (inside - middle) @ outwards >= 0.5 * pose[WIDTH] + LEAST_BESIDE * side:
            corners.append((column, row))
    if not corners:
        return None
    patches = tuple(_patch(picture, corner, side) for corner in corners)
    return GroundPatches(picture.shape, tuple(corners), patches)


def ground_shifts(before: GroundPatches, picture: Image) -> FloatArray | None:
    """Return how far the ground of each patch has moved, x to the right, y up, shape (K, 2) [px].

    None where that cannot be told of all, or the picture has another size than the one before.
    """
    if picture.shape != before.shape:
        return None
    side = len(before.patches[0])
    window = _window(side)
    shifts = []
    for corner, patch in zip(before.corners, before.patches, strict=True):
        (right, down), response = cv2.phaseCorrelate(patch, _patch(picture, corner, side), window)
        if response < LEAST_RESPONSE or max(abs(right), abs(down)) > LARGEST_SHIFT * side:
            return None
        shifts.append((right, -down))
    return np.array(shifts)


def _centre(corner: tuple[int, int], side: int, shape: tuple[int, ...]) -> FloatArray:
    """Return the centre of a patch of a picture (h, w) in the image frame, shape (2,) [px]."""
    (column, row), (height, width) = corner, shape
    return np.array([column - 0.5 * (width - side), 0.5 * (height - side) - row])


def _patch(picture: Image, corner: tuple[int, int], side: int) -> Image:
    """Return a square of a picture, its mean taken off."""
    column, row = corner
    patch = picture[row : row + side, column : column + side]
    return np.asarray(patch - patch.mean())


@cache
def _window(side: int) -> Image:
    """Return the weights of the pixels of a patch: its edges must not pass for texture."""
    return np.asarray(cv2.createHanningWindow((side, side), cv2.CV_32F))


@dataclass(frozen=True, slots=True, eq=False)
class FixtureTest:
    """What looks at the ground have told of the hypothesis that leads.

    Attributes
    ----------
    seconds : float
        Time since the last look [s].
    state : FloatArray
        The hypothesis then, shape (8,).
    patches : GroundPatches or None
        Ground beside it then; None: there is no room on either side, or no hypothesis.
    looks : int
        Number of looks in which all ground looked at has shifted the same way.
    ground, strip : float
        How far ground and hypothesis have travelled across the hypothesis, less of what is long ago
        [px].
    ground_path, strip_path : float
        Lengths of the path of the ground in any direction, and of that of the hypothesis across
        itself, to and fro, likewise [px].
    fixture : FloatArray or None
        The last state (8,) that was found to be fixed to the vehicle.
    """

    seconds: float
    state: FloatArray
    patches: GroundPatches | None
    looks: int = 0
    ground: float = 0.0
    strip: float = 0.0
    ground_path: float = 0.0
    strip_path: float = 0.0
    fixture: FloatArray | None = None

    @property
    def is_still(self) -> bool:
        """Whether the ground has moved across the hypothesis, and the hypothesis has not."""
        across = abs(self.ground)
        stands = abs(self.strip) < STILL * across and self.strip_path < MOVING * across
        return self.looks >= FEWEST_LOOKS and stands and across > LEAST_ACROSS * self.ground_path


UNTESTED = FixtureTest(0.0, np.zeros(STATE_SIZE), None)
"""No look was taken."""


def fixture_test_after(
    before: FixtureTest,
    leader: FloatArray,
    image: WorkingImage,
    dt: float,
    travel: float,
    *,
    goes_on: bool,
) -> FixtureTest:
    """Return the test after one more frame.

    Parameters
    ----------
    before : FixtureTest
        That after the frame before.
    leader : FloatArray
        The leading hypothesis, shape (8,).
    image : WorkingImage
        The frame.
    dt : float
        Time since the frame before [s].
    travel : float
        How far the ground has to move across a fixture [px].
    goes_on : bool
        Whether the hypothesis continues the one that led before the frame.
    """
    if not goes_on:
        return FixtureTest(0.0, leader, _patches(leader, image), fixture=before.fixture)
    if before.seconds + dt < LOOK_INTERVAL:
        return replace(before, seconds=before.seconds + dt)
    shifts = None if before.patches is None else ground_shifts(before.patches, image.pixels)
    told = before
    if before.patches is not None and shifts is not None:
        centres = before.patches.centres() / image.reduction
        told = _travelled(before, leader, centres, shifts / image.reduction, image.frame_size)
    fixture = before.fixture
    if abs(told.ground) >= travel:
        if told.is_still:
            fixture = leader
        elif abs(told.strip) >= MOVING * abs(told.ground):
            fixture = None
    patches = _patches(leader, image)
    return replace(told, seconds=0.0, state=leader, patches=patches, fixture=fixture)


def _patches(leader: FloatArray, image: WorkingImage) -> GroundPatches | None:
    """Return the ground beside a hypothesis, shape (8,); None where there is no room for it."""
    pose = leader[:POSE_SIZE] * pose_units(image.reduction)
    return patches_beside(pose, image.pixels, image.scale)


def _across(strip: FloatArray, centres: FloatArray, shifts: FloatArray) -> FloatArray:
    """Return how far ground has shifted across a strip, shape (K,) [px].

    Lines along the strip on the ground meet in the image where its borders do. What has shifted is
    counted across the one of them that the ground lies on.

    Parameters
    ----------
    strip : FloatArray
        The strip, shape (8,).
    centres, shifts : FloatArray
        Where the ground lies in the image frame, and how far it has shifted, shape (K, 2) [px].
    """
    distance, angle, width, skew = strip[:POSE_SIZE]
    upwards = np.array([-np.sin(angle), np.cos(angle)])
    along = np.tan(skew) * (foot_point(distance, angle) - centres) + 0.5 * width * upwards
    normals = np.column_stack((along[:, 1], -along[:, 0]))
    across: FloatArray = (shifts * normals).sum(1) / np.maximum(np.hypot(*normals.T), 1e-9)
    return across


def _travelled(
    before: FixtureTest,
    leader: FloatArray,
    centres: FloatArray,
    shifts: FloatArray,
    image_size: tuple[int, int],
) -> FixtureTest:
    """Return a test with one more shift of the ground beside the strip; see `_across`."""
    (then,) = states_in_chart(before.state[None], float(leader[ANGLE]))
    normal = np.array([np.cos(then[ANGLE]), np.sin(then[ANGLE])])
    sides = _across(then, centres, shifts)
    middle = middle_inside(float(leader[ANGLE]), float(leader[DISTANCE]), image_size)
    across, strip, looks = 0.0, 0.0, before.looks
    # Where the two sides do not go the same way, the strip is held against nothing.
    if middle is not None and (np.sign(sides) == np.sign(sides[0])).all():
        across = float(min(sides, key=abs))
        strip = float(normal @ middle - then[DISTANCE])
        looks += 1
    return replace(
        before,
        looks=looks,
        ground=KEPT * before.ground + across,
        strip=KEPT * before.strip + strip,
        ground_path=KEPT * before.ground_path + float(np.hypot(*shifts.T).mean()),
        strip_path=KEPT * before.strip_path + abs(strip),
    )
