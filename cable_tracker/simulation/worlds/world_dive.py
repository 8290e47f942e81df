"""Dives through worlds: frame by frame, with exact ground truth."""

from __future__ import annotations

import zlib
from collections.abc import Iterator

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image, eight_bits
from cable_tracker.cable.model.geometry import wrap_state
from cable_tracker.cable.model.state import LENGTHS, WIDTH, CableState
from cable_tracker.simulation.dive import SimulatedFrame, make_frame
from cable_tracker.simulation.rendering.texture import in_rows, smooth_step
from cable_tracker.simulation.settings import check_seed, check_size
from cable_tracker.simulation.worlds.cable_appearance import (
    GROWTH_REACH,
    SAND_REACH,
    CableAppearance,
    random_cable_appearance,
    random_coat,
)
from cable_tracker.simulation.worlds.camera_faults import (
    LossyCodec,
    random_light,
    random_overlay,
    random_sway,
)
from cable_tracker.simulation.worlds.catalogue import WORLDS, World
from cable_tracker.simulation.worlds.clutter import add_clutter, random_clutter
from cable_tracker.simulation.worlds.ground import random_texture, sample_texture
from cable_tracker.simulation.worlds.motion import WORLD_RATE, random_motion
from cable_tracker.simulation.worlds.strip import (
    StripView,
    border_points,
    pixel_grid,
    view_strip,
)
from cable_tracker.tracking.image_frame import to_pixel
from cable_tracker.tracking.parameter_table import REFERENCE_WIDTH, named, pixel_scale

ROW = 512
"""Pixels near a cable are gathered into rows of this length."""

WORLD_SIZE = (320, 240)
"""Width and height of the frames of the worlds, unless said otherwise [px]."""

LEAST_STEP = 0.55
"""Smallest step of a visible border [standard deviations of the bottom]."""

STEP_OVER_NOISE = 1.2
"""Smallest step of a visible border in the picture [standard deviations of the sensor's noise]."""

LEAST_SHARE = 0.2
"""Smallest visible share of the borders; with less it is open whether a person sees the cable."""

POINT_SPACING = 3.0
"""Distance of the points of a border at which its visibility is checked [px]."""

GREY_LEVELS = (55.0, 150.0)
"""Darkest and brightest mean of a bottom [grey levels]."""

WHITE = 235.0
"""The exposure keeps bottom and cable below this [grey levels]."""

BOTTOM_CONTRAST = (0.07, 0.22)
"""Standard deviation of a bottom over its mean."""

TRAVEL_SPEED = (10.0, 60.0)
"""Way over the bottom [px/s at 320 px]."""

SHADOW_DEPTHS = (1.5, 4.0)
"""Smallest and largest step of a cast shadow [standard deviations of the bottom]."""


def simulate_world(
    world: str | World, seed: int = 0, image_size: tuple[int, int] = WORLD_SIZE
) -> Iterator[SimulatedFrame]:
    """Yield the frames of a dive through a world at 25 frames per second, always the same.

    Parameters
    ----------
    world : str or World
        One of `WORLDS`, or one's own.
    seed : int
        Not negative; each is another dive.
    image_size : (int, int)
        Width and height [px].

    Raises
    ------
    ParameterError
        There is no world of that name, the seed is negative, or images cannot have that size.
    RecordingError
        The world needs photographs, and there are none.
    """
    if isinstance(world, str):
        world = named("world", world, WORLDS)
    return WorldDive(world, seed, image_size).frames()


class WorldDive:
    """One dive through a world.

    Parameters
    ----------
    world : World
        World to draw the dive from.
    seed : int
        Not negative. The same seed gives the same frames, bit for bit.
    image_size : (int, int)
        Width and height [px]; lengths scale with the width.

    Raises
    ------
    ParameterError
        The seed is negative, or images cannot have that size.
    RecordingError
        The world needs photographs, and there are none.
    """

    def __init__(self, world: World, seed: int, image_size: tuple[int, int] = WORLD_SIZE) -> None:
        check_seed(seed)
        check_size(image_size)
        self.world = world
        name = zlib.crc32(world.name.encode())
        self._size = image_size
        self._scale = pixel_scale(image_size[0])
        route, scenery, picture, self._grain = (
            np.random.default_rng(each)
            for each in np.random.SeedSequence((world.split.number, name, seed)).spawn(4)
        )
        self._draw_route(route)
        self._draw_scenery(scenery)
        self._draw_picture(picture)

    def _draw_route(self, rng: np.random.Generator) -> None:
        world = self.world
        kind = world.motions[int(rng.integers(len(world.motions)))]
        width, height = self._size
        self.states = random_motion(
            kind,
            world.widths,
            world.angles,
            world.frame_count,
            rng,
            height=REFERENCE_WIDTH * height / width,
        )
        self.states[:, LENGTHS] *= self._scale
        # On the bottom a texel is a pixel where the view is middling.
        self._unit = float(self.states[:, WIDTH].mean()) / (2 * self._scale)
        speed = float(rng.uniform(*TRAVEL_SPEED))
        self._travel = speed * np.arange(world.frame_count) / WORLD_RATE

    def _draw_scenery(self, rng: np.random.Generator) -> None:
        world = self.world
        self._bottom = random_texture(world.split, world.photographed, rng)
        self._far_bottom = cv2.GaussianBlur(
            self._bottom, (0, 0), 3.0, borderType=cv2.BORDER_REFLECT
        )
        self._skin = random_texture(world.split, False, rng)
        self._places = rng.uniform(0.0, 4096.0, (3, 2)).astype(np.float32)
        extent = (-600.0, 600.0 + float(self._travel[-1]))
        self._cable: CableAppearance | None = None
        if world.has_cable:
            radii = (extent[0] / self._unit, extent[1] / self._unit)
            self._cable = random_cable_appearance(world, radii, rng)
        disturbance = world.disturbance
        self._clutter = random_clutter(
            world.split, extent, disturbance.lines, disturbance.pairs, rng
        )
        self._coat = random_coat(world.coat, world.split, rng)
        self._shadow: tuple[int, float, float] | None = None
        if rng.random() < disturbance.shadow:
            self._shadow = (
                int(rng.choice((-1, 1))),
                float(rng.uniform(0.3, 1.6)),
                float(rng.uniform(*SHADOW_DEPTHS)),
            )

    def _draw_picture(self, rng: np.random.Generator) -> None:
        optics = self.world.optics
        step = 0.0 if self._cable is None else self._cable.step
        grey = float(rng.uniform(*GREY_LEVELS))
        spread = grey * float(rng.uniform(*BOTTOM_CONTRAST))
        self._light = random_light(optics, self._size, rng)
        brightest = WHITE / float(np.quantile(self._light, 0.95))
        self._grey = min(grey, 0.7 * brightest)
        darkest = max(self._coat.limbs - step, 1.0)
        self._spread = min(
            spread, 0.85 * self._grey / darkest, (brightest - self._grey) / max(step, 1.0)
        )
        self._flicker = (float(rng.uniform(0.0, 0.12)), float(rng.uniform(0.2, 2.0)))
        self._haze = float(rng.uniform(*optics.haze))
        self._blur = float(rng.uniform(*optics.blur)) * self._scale
        self._noise = float(rng.uniform(*optics.noise))
        self._overlay = random_overlay(self.world.disturbance, self._size, rng)
        quality = None if optics.quality is None else int(rng.integers(*optics.quality))
        self._codec = LossyCodec(quality, as_video=bool(rng.random() < 0.5))
        self._sway = random_sway(optics, self._scale, rng)
        self._x, self._y = pixel_grid(self._size)

    def frames(self) -> Iterator[SimulatedFrame]:
        """Render the frames, once."""
        for index, state in enumerate(self.states):
            image = self._render(index, state)
            visibility = self._visibility(index, state)
            truth = CableState.from_array(wrap_state(state)) if visibility != 0.0 else None
            yield SimulatedFrame(make_frame(index, WORLD_RATE, image, truth), visibility)

    def _render(self, index: int, state: FloatArray) -> Image:
        view = view_strip(state, self._x, self._y)
        # Radii from the foot point at the start of the dive.
        along = view.v + np.float32(self._travel[index] / self._unit)
        tone = self._ground(view, along)
        if self._cable is not None:
            tone = self._lay_cable(tone, view, along, self._cable)
        light = self._light_at(index)
        if self._flicker[0] > 0.0:
            depth, rate = self._flicker
            light = light * np.float32(1 + depth * np.sin(rate * index / WORLD_RATE))
        image: Image = (np.float32(self._grey) + np.float32(self._spread) * tone) * light
        image += self._fog(view.radius) * (np.float32(self._grey) * light - image)
        image = cv2.GaussianBlur(image, (0, 0), max(self._blur, 0.3))
        grain: Image = self._grain.standard_normal(image.shape, np.float32)
        image = image + np.float32(self._noise) * grain
        picture = eight_bits(image)
        self._overlay.draw_on(picture, index)
        return self._codec.transcode(picture)

    def _light_at(self, index: int) -> Image:
        return self._sway.moved(self._light, index / WORLD_RATE)

    def _ground(self, view: StripView, along: Image) -> Image:
        unit = np.float32(self._unit)
        x, y = view.u * unit, along * unit
        right, up = self._places[0]
        tone = sample_texture(self._bottom, x + right, y + up)
        texel = unit * np.float32(self._scale) / view.radius
        if float(texel.max()) > 1.5:
            share = np.clip((texel - 1) / 3, 0.0, 1.0)
            tone = tone + share * (sample_texture(self._far_bottom, x + right, y + up) - tone)
        return add_clutter(tone, self._clutter, x, y) if self._clutter else tone

    def _lay_cable(
        self, tone: Image, view: StripView, along: Image, cable: CableAppearance
    ) -> Image:
        """Return the tone of the picture, float32 (H, W), with cable, shadow, growth and sand."""
        reach = self._cable_reach(cable)
        found = np.flatnonzero(np.abs(view.u) < reach)
        if found.size == 0:
            return tone
        near = in_rows(found, ROW)
        part = StripView(*(each.reshape(-1)[near] for each in (view.u, view.v, view.radius)))
        laid = tone.copy()
        laid.reshape(-1)[near] = self._cable_on(
            tone.reshape(-1)[near], part, along.reshape(-1)[near], cable
        )
        return laid

    def _cable_reach(self, cable: CableAppearance) -> float:
        """Return the distance from its axis up to which the cable changes the picture [radii]."""
        if cable.drifts:
            return max(SAND_REACH, self._shadow_reach())
        reach = max(self._coat.reach, self._shadow_reach())
        return max(reach, GROWTH_REACH) if cable.growth > 0.0 else reach

    def _shadow_reach(self) -> float:
        return 0.0 if self._shadow is None else self._shadow[1] + 1.0

    def _cable_on(
        self, tone: Image, view: StripView, along: Image, cable: CableAppearance
    ) -> Image:
        u, unit = view.u, np.float32(self._unit)
        soft = np.maximum(np.float32(1.0) / view.radius, np.float32(0.03))
        if self._shadow is not None:
            side, length, depth = self._shadow
            reach = side * u
            shade = (1 - smooth_step(reach, length + 0.7, length + 1.0)) * (reach > 0)
            tone = tone - np.float32(depth) * shade
        skin = sample_texture(
            self._skin, u * unit + self._places[1][0], along * unit + self._places[1][1]
        )
        surface = self._coat.tone(u, along, cable.contrast(along), skin)
        cover = np.clip((self._coat.edge(u, along) - np.abs(u)) / soft + 0.5, 0.0, 1.0)
        tone = tone + cover * (surface - tone)
        grown, sand = cable.growth_cover(u, along), cable.sand_covers(u, along, 2 * soft)
        if grown is None and not sand:
            return tone
        right, up = self._places[2]
        other = sample_texture(self._bottom, u * unit + right, along * unit + up)
        if grown is not None:
            tone = tone + grown * (other - tone)
        for share, sand_tone in sand:
            tone = tone + share * (0.7 * other + np.float32(sand_tone) - tone)
        return tone

    def _fog(self, radius: Image) -> Image:
        """Return the loss of contrast by haze, which grows with distance, float32, 0 to 1."""
        near = np.float32(self._unit * self._scale)
        return np.float32(self._haze) * (1 - np.minimum(radius / near, 1.0))

    def _visibility(self, index: int, state: FloatArray) -> float:
        """Return the visible share of the borders in view; NaN below `LEAST_SHARE`."""
        if self._cable is None:
            return 0.0
        x, y = border_points(state, self._size, POINT_SPACING * self._scale)
        if x.shape[1] == 0:
            return 0.0
        view = view_strip(state, x, y)
        along = view.v + np.float32(self._travel[index] / self._unit)
        columns, rows = (np.rint(each).astype(np.intp) for each in to_pixel(x, y, self._size))
        clear = 1 - self._fog(view.radius)
        step = np.abs(self._cable.contrast(along) - self._coat.darkening(view.u)) * clear
        visible = step >= LEAST_STEP
        lit = self._spread * self._light_at(index)[rows, columns]
        visible &= step * lit >= STEP_OVER_NOISE * self._noise
        visible &= ~self._overlay.covered[rows, columns]
        grown = self._cable.growth_cover(view.u, along)
        if grown is not None:
            visible &= grown < 0.5
        for sand, _ in self._cable.sand_covers(view.u, along, 0.1):
            visible &= sand < 0.5
        share = float(visible.mean())
        return share if share >= LEAST_SHARE else float("nan")
