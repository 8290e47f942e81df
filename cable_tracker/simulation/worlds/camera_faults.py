"""Effects between the bottom and a recording: light, noise, compression, and covered pixels."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from cable_tracker.arrays import BoolArray, Image
from cable_tracker.sequences.pictures.encoded_pictures import after_jpeg
from cable_tracker.simulation.worlds.catalogue import Disturbance, Optics
from cable_tracker.tracking.parameter_table import pixel_scale

BAR_SHARES = (0.03, 0.16)
"""Smallest and largest share of the picture that one black bar takes."""

INTRA_PERIOD = 12
"""Number of pictures from one whole picture of a compressed video to the next."""

LEAST_LIGHT = 0.08
"""Smallest light of a pixel, as a share of the mean over the picture."""


def random_light(optics: Optics, image_size: tuple[int, int], rng: np.random.Generator) -> Image:
    """Draw the light on each pixel, about 1 on average, float32, shape (H, W)."""
    width, height = image_size
    x = (np.arange(width, dtype=np.float32) / (width - 1) - 0.5)[None, :]
    y = (np.arange(height, dtype=np.float32) / (height - 1) - 0.5)[:, None]
    uneven = float(rng.uniform(*optics.lamps))
    beams = np.zeros((height, width), np.float32)
    for side in (-1, 1):
        right, up = side * rng.uniform(0.0, 0.35), rng.uniform(-0.3, 0.3)
        spread = rng.uniform(0.2, 0.45)
        beams += np.float32(rng.uniform(0.5, 1.0)) * np.exp(
            -((x - right) ** 2 + (y - up) ** 2) / np.float32(2 * spread**2)
        )
    beams /= max(float(beams.mean()), 1e-3)
    light = 1 - uneven + uneven * beams
    dark = float(rng.uniform(*optics.vignette))
    light *= 1 - np.float32(dark) * np.minimum(2 * (x * x + y * y), 1.0)
    return np.asarray(np.maximum(light / light.mean(), LEAST_LIGHT), np.float32)


@dataclass(frozen=True, slots=True)
class LampMotion:
    """How the light of the lamps moves over the picture.

    Attributes
    ----------
    reach : (float, float)
        Amplitudes of the motion to the right and up [px].
    rates, phases : (float, float)
        Angular rates and phases of the motions to the right and up [rad/s, rad].
    """

    reach: tuple[float, float]
    rates: tuple[float, float]
    phases: tuple[float, float]

    def moved(self, light: Image, seconds: float) -> Image:
        """Return a light, float32 of shape (H, W), shifted as after some time [s]."""
        if not any(self.reach):
            return light
        right, up = (
            reach * math.sin(rate * seconds + phase)
            for reach, rate, phase in zip(self.reach, self.rates, self.phases, strict=True)
        )
        shift = np.array(((1.0, 0.0, right), (0.0, 1.0, -up)))
        height, width = light.shape
        moved = cv2.warpAffine(light, shift, (width, height), borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(moved, np.float32)


def random_sway(optics: Optics, scale: float, rng: np.random.Generator) -> LampMotion:
    """Draw how the lamps move; `scale`: pixels per pixel at 320 px."""
    reach = scale * rng.uniform(*optics.sway, 2)
    rates, phases = rng.uniform(0.5, 3.0, 2), rng.uniform(0.0, 2 * np.pi, 2)
    return LampMotion(*((float(right), float(up)) for right, up in (reach, rates, phases)))


@dataclass(frozen=True, slots=True, eq=False)
class Overlay:
    """Pixels drawn over the picture; only the figures of the captions change from frame to frame.

    Attributes
    ----------
    pixels : Image
        Grey levels, uint8, shape (H, W).
    covered : BoolArray
        Covered pixels, shape (H, W).
    captions : tuple of (int, int)
        Column and row of the lower left corner of each line of text [px].
    """

    pixels: Image
    covered: BoolArray
    captions: tuple[tuple[int, int], ...]

    def draw_on(self, picture: Image, frame: int) -> None:
        """Draw it over a picture, uint8 of shape (H, W), in place."""
        picture[self.covered] = self.pixels[self.covered]
        size = 0.35 * pixel_scale(picture.shape[1])
        for number, corner in enumerate(self.captions):
            text = f"{12 + number}:{frame // 25:02d}:{frame % 25:02d} D{101 + frame % 7}.{number}"
            for grey, thickness in ((0, 3), (235, 1)):
                cv2.putText(picture, text, corner, cv2.FONT_HERSHEY_SIMPLEX, size, grey, thickness)


def random_overlay(
    disturbance: Disturbance, image_size: tuple[int, int], rng: np.random.Generator
) -> Overlay:
    """Draw the overlay of a dive at random: vehicle part, black bars, captions, crosshair."""
    width, height = image_size
    pixels = np.zeros((height, width), np.uint8)
    covered = np.zeros((height, width), np.bool_)
    if rng.random() < disturbance.vehicle_part:
        _draw_part(pixels, covered, rng)
    if rng.random() < disturbance.bars:
        share = float(rng.uniform(*BAR_SHARES))
        grey = int(rng.choice((0, 0, 16)))
        bars = _bars((height, width), share, bool(rng.random() < 0.5), bool(rng.random() < 0.8))
        pixels[bars], covered[bars] = grey, True
    captions: tuple[tuple[int, int], ...] = ()
    if rng.random() < disturbance.caption:
        corners = ((4, round(0.06 * height)), (4, height - 6), (width // 2, round(0.06 * height)))
        captions = corners[: int(rng.integers(1, 4))]
    # Worlds without one draw no number for it: their dives stay as they were.
    if disturbance.crosshair and rng.random() < disturbance.crosshair:
        _draw_crosshair(pixels, covered, rng)
    return Overlay(pixels, covered, captions)


def _bars(shape: tuple[int, int], share: float, lying: bool, both: bool) -> BoolArray:
    bars = np.zeros(shape, np.bool_)
    if lying:
        thick = round(share * shape[0])
        bars[:thick] = True
        bars[shape[0] - thick :] |= both
    else:
        thick = round(share * shape[1])
        bars[:, :thick] = True
        bars[:, shape[1] - thick :] |= both
    return bars


def _draw_part(pixels: Image, covered: BoolArray, rng: np.random.Generator) -> None:
    """Draw an arm or a skid that comes in from the lower edge."""
    height, width = pixels.shape
    foot = rng.uniform(0.0, 1.0) * width
    tip = (foot + rng.normal(0.0, 0.15) * width, height * rng.uniform(0.6, 0.85))
    half = rng.uniform(0.02, 0.06) * width
    corners = np.array(
        (
            (foot - 1.6 * half, height),
            (tip[0] - half, tip[1]),
            (tip[0] + half, tip[1]),
            (foot + 1.6 * half, height),
        )
    )
    mask = np.zeros_like(pixels)
    cv2.fillPoly(mask, [np.rint(corners).astype(np.int32)], 1)
    covered |= mask > 0
    grain = rng.normal(0.0, 3.0, pixels.shape) + rng.uniform(10.0, 200.0)
    pixels[mask > 0] = np.clip(grain, 0, 255).astype(np.uint8)[mask > 0]


def _draw_crosshair(pixels: Image, covered: BoolArray, rng: np.random.Generator) -> None:
    """Draw a line down and one across the middle, with marks on them."""
    height, width = pixels.shape
    unit = pixel_scale(width)
    thickness = max(1, round(unit * rng.uniform(0.5, 1.5)))
    reach = float(rng.choice((0.3, 0.5, 0.5)))
    middle = np.array((width // 2, height // 2))
    mask = np.zeros_like(pixels)
    for direction, side in (((1, 0), width), ((0, 1), height)):
        along = np.array(direction)
        for mark in range(-5, 6):
            place = middle + along * round(mark * reach * side / 5)
            half = (along[::-1] * 4 * unit).round().astype(int)
            cv2.line(mask, (place - half).tolist(), (place + half).tolist(), 1, thickness)
        half = along * round(reach * side)
        cv2.line(mask, (middle - half).tolist(), (middle + half).tolist(), 1, thickness)
    pixels[mask > 0] = int(rng.choice((0, 235, 235, 255)))
    covered |= mask > 0


class LossyCodec:
    """Compresses pictures as a camera or a recorder does, and decodes them again.

    Parameters
    ----------
    quality : int or None
        1 to 100; None: pictures stay as they are.
    as_video : bool
        Whether differences from the picture before are compressed.
    """

    def __init__(self, quality: int | None, *, as_video: bool) -> None:
        self._quality = quality
        self._as_video = as_video
        self._last: Image | None = None
        self._count = 0

    def transcode(self, picture: Image) -> Image:
        """Return the next picture, uint8 of shape (H, W), after encoding and decoding."""
        if self._quality is None:
            return picture
        whole = not self._as_video or self._last is None or self._count % INTRA_PERIOD == 0
        self._count += 1
        if whole or self._last is None:
            self._last = self._after_jpeg(picture)
            return self._last
        before = self._last.astype(np.int16)
        difference = np.clip((picture.astype(np.int16) - before) // 2 + 128, 0, 255)
        decoded = self._after_jpeg(difference.astype(np.uint8)).astype(np.int16)
        self._last = np.clip(before + 2 * (decoded - 128), 0, 255).astype(np.uint8)
        return self._last

    def _after_jpeg(self, picture: Image) -> Image:
        assert self._quality is not None
        return after_jpeg(picture, self._quality)
