"""Appearance of targets: painted polygons in a frame of the body."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image

SHIFT = 4
"""Binary places of a pixel in which OpenCV takes corners."""

FINENESS = 2
"""Pixels are painted this fine, and averaged."""


@dataclass(frozen=True, slots=True, eq=False)
class Patch:
    """A polygon of one colour.

    Attributes
    ----------
    corners : FloatArray
        Shape (K, 2), in units of the body's size: x ahead, y up.
    colour : (float, float, float)
        Blue, green, red, 0 to 255.
    """

    corners: FloatArray
    colour: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class ImagePose:
    """Pose of a body in the image.

    Attributes
    ----------
    x, y : float
        Position of the body's origin, from the top left corner, y downwards [px].
    size : float
        Length of its unit [px].
    angle : float
        Counter-clockwise as one sees it [rad].
    foreshortening : float
        Factor on its x where it is turned towards the camera.
    phase : float
        Phase of the body's own movement [rad].
    """

    x: float
    y: float
    size: float
    angle: float = 0.0
    foreshortening: float = 1.0
    phase: float = 0.0


def _ellipse(x: float, y: float, a: float, b: float, tilt: float = 0.0) -> FloatArray:
    turn = np.linspace(0.0, 2.0 * math.pi, 33)[:-1]
    across, along = a * np.cos(turn), b * np.sin(turn)
    c, s = math.cos(tilt), math.sin(tilt)
    return np.stack((x + c * across - s * along, y + s * across + c * along), axis=1)


def _box(x0: float, y0: float, x1: float, y1: float) -> FloatArray:
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])


def buoy(_phase: float) -> list[Patch]:
    """Return a red buoy with a dark foot; its unit is its diameter."""
    return [
        Patch(
            np.array([[-0.16, -0.42], [0.16, -0.42], [0.06, -0.68], [-0.06, -0.68]]), (70, 30, 40)
        ),
        Patch(_ellipse(0.0, 0.0, 0.5, 0.52), (45, 35, 200)),
        Patch(_ellipse(-0.14, 0.18, 0.18, 0.14, 0.6), (75, 65, 230)),
        Patch(_ellipse(0.08, -0.3, 0.3, 0.14), (38, 26, 160)),
    ]


def vehicle(_phase: float) -> list[Patch]:
    """Return a yellow torpedo with dark fins; its unit is its length."""
    return [
        Patch(np.array([[-0.5, 0.2], [-0.32, 0.2], [-0.26, -0.2], [-0.5, -0.2]]), (40, 40, 45)),
        Patch(_box(-0.42, -0.12, 0.36, 0.12), (40, 185, 215)),
        Patch(_ellipse(0.36, 0.0, 0.14, 0.12), (60, 60, 70)),
        Patch(_box(-0.1, -0.12, 0.02, 0.12), (35, 35, 40)),
        Patch(_box(-0.36, 0.03, 0.3, 0.09), (70, 215, 240)),
    ]


def diver(phase: float) -> list[Patch]:
    """Return a diver whose arms and legs move; the unit is the body's length."""
    suit, fins, bottle, skin = (60, 45, 40), (40, 200, 220), (50, 110, 225), (120, 150, 200)
    patches = []
    for sign in (-1.0, 1.0):
        swing = 0.45 * math.sin(phase + (0.0 if sign > 0 else math.pi))
        knee = np.array([-0.32, 0.02 * sign]) + 0.12 * np.array([-math.cos(swing), math.sin(swing)])
        foot = knee + 0.16 * np.array([-math.cos(0.6 * swing), math.sin(0.6 * swing)])
        tip = foot + 0.15 * np.array([-math.cos(1.4 * swing), math.sin(1.4 * swing)])
        patches += [
            Patch(_limb(np.array([-0.18, 0.03 * sign]), knee, 0.055), suit),
            Patch(_limb(knee, foot, 0.04), suit),
            Patch(_limb(foot, tip, 0.05), fins),
        ]
        hand = np.array([0.2, 0.0]) + 0.24 * np.array(
            [math.cos(1.2 * swing), math.sin(1.2 * swing)]
        )
        patches.append(Patch(_limb(np.array([0.18, 0.0]), hand, 0.032), suit))
        patches.append(Patch(_ellipse(hand[0], hand[1], 0.03, 0.03), skin))
    return [
        *patches,
        Patch(_ellipse(0.0, 0.0, 0.24, 0.1), suit),
        Patch(_box(-0.14, 0.06, 0.14, 0.14), bottle),
        Patch(_ellipse(0.28, 0.03, 0.075, 0.07), skin),
    ]


def _limb(start: FloatArray, end: FloatArray, half_width: float) -> FloatArray:
    along = (end - start) / max(float(np.hypot(*(end - start))), 1e-9)
    across = half_width * np.array([-along[1], along[0]])
    return np.array([start - across, end - 0.7 * across, end + 0.7 * across, start + across])


def box_vehicle(_phase: float) -> list[Patch]:
    """Return a box-shaped vehicle of nearly the colour of the water; its unit is its width."""
    return [
        Patch(_box(-0.5, -0.3, 0.5, 0.3), (105, 110, 72)),
        Patch(_box(-0.5, 0.12, 0.5, 0.3), (118, 128, 92)),
        Patch(_box(-0.16, -0.2, 0.16, 0.06), (84, 88, 60)),
    ]


def paint(patches: list[Patch], pose: ImagePose, size: tuple[int, int]) -> tuple[Image, Image]:
    """Paint a body.

    Returns
    -------
    colours : Image
        Float32, shape (H, W, 3), premultiplied by the coverage.
    coverage : Image
        Share of every pixel that it covers, float32, shape (H, W).
    """
    width, height = size
    fine = (height * FINENESS, width * FINENESS)
    colours, coverage = np.zeros((*fine, 3), np.float32), np.zeros(fine, np.float32)
    c, s = math.cos(pose.angle), math.sin(pose.angle)
    for patch in patches:
        ahead, up = (
            pose.size * patch.corners[:, 0] * pose.foreshortening,
            pose.size * patch.corners[:, 1],
        )
        x, y = pose.x + c * ahead - s * up, pose.y - s * ahead - c * up
        corners = np.stack((x, y), axis=1) + 0.5
        fixed = np.round((corners * FINENESS - 0.5) * 2**SHIFT).astype(np.int32)
        cv2.fillPoly(colours, [fixed], patch.colour, cv2.LINE_8, SHIFT)
        cv2.fillPoly(coverage, [fixed], (1.0,), cv2.LINE_8, SHIFT)
    return (
        cv2.resize(colours, size, interpolation=cv2.INTER_AREA),
        cv2.resize(coverage, size, interpolation=cv2.INTER_AREA),
    )
