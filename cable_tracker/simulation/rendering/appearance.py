"""Appearance of a scene: bottom, cable, water, light and sensor."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Bottom:
    """Composition of the sea bed.

    Attributes
    ----------
    tone : float
        Mean reflected light, 0 to 1.
    ripples, stones, algae, gravel : float
        Amount of each; 1 is usual for the first three, 0 none.
    ripple_angle : float or None
        Angle of the ripples' crests from the cable's course, to the left [deg]; None: drawn.
    """

    tone: float = 0.31
    ripples: float = 1.0
    stones: float = 1.0
    algae: float = 1.0
    gravel: float = 0.0
    ripple_angle: float | None = None


@dataclass(frozen=True, slots=True)
class Skin:
    """The outside of a cable.

    Attributes
    ----------
    tone : float
        Reflected light, 0 to 1.
    stains : float
        Strength of blotches, 0 to 1.
    cover : float
        How much grows on it and beside it and how much sand lies on it, 0 to 1; at 1 about four
        tenths of the borders are hidden.
    turf : float
        Share of the borders' length that is hidden by growth and sediment that resemble the
        bottom around, 0 to 1. It leaves a soft ridge without edges.
    silt : float
        Mean opacity of the thin film that resembles the bottom, on all of the cable, 0 to 0.45. It
        takes contrast away and hides nothing.
    bulge : float
        Standard deviation of the distance by which crusts on the sides push the visible border
        outwards or keep it inwards [radii].
    drift : float
        Share of the cable's length along which sand has drifted over one of its sides, 0 to 0.9.
        There one border is hidden and the edge of the sand runs along the cable instead.
    shade : float
        Strength of the shadows beside the cable, 0 to 1.
    gap_lengths : (float, float)
        Shortest and longest of the short stretches at which the cable is buried altogether [radii].
    """

    tone: float = 0.57
    stains: float = 0.7
    cover: float = 0.5
    turf: float = 0.0
    silt: float = 0.0
    bulge: float = 0.0
    drift: float = 0.0
    shade: float = 1.0
    gap_lengths: tuple[float, float] = (1.0, 3.0)


@dataclass(frozen=True, slots=True)
class Lamp:
    """A lamp on the vehicle.

    Attributes
    ----------
    place : (float, float, float)
        Position in the camera frame [m]: right, up, back.
    aim : (float, float)
        Direction of the lamp: to the right and up from the camera's view [rad].
    spread : float
        Angle from its axis at which the light has fallen to 1/e [rad].
    strength : float
        Light on the beam's axis at the distance `water.REFERENCE_RANGE`; 1 shows a surface with its
        reflected share.
    """

    place: tuple[float, float, float]
    aim: tuple[float, float]
    spread: float
    strength: float


@dataclass(frozen=True, slots=True)
class Water:
    """Effects of the water on light.

    Attributes
    ----------
    absorption : float
        Share of the light that is lost [1/m].
    scatter : float
        Rate at which the veil of scattered light closes with distance [1/m].
    veil : float
        Brightness of the closed veil, 0 to 1.
    blur : float
        Standard deviation of the blur [px at a width of 320].
    flakes : float
        Marine snow, 0 (none) to 1 (much).
    """

    absorption: float = 0.18
    scatter: float = 0.16
    veil: float = 0.3
    blur: float = 0.8
    flakes: float = 0.5


@dataclass(frozen=True, slots=True)
class SceneAppearance:
    """Appearance of a scene, without its geometry.

    Attributes
    ----------
    bottom : Bottom
        The sea bed.
    skin : Skin
        The cable's.
    water : Water
        Between camera and bottom.
    daylight : float
        Even light from above, relative to the lamps.
    lamps : tuple of Lamp or None
        None: two lamps drawn at random.
    clutter : float
        Density of ropes, furrows and tracks, 0 to 1.
    companions : float
        How many furrows, ropes and pairs of lines run alongside the cable, nearly parallel to it,
        0 to 1.
    noise : float
        Standard deviation of the sensor's noise [grey levels].
    jpeg_quality : int or None
        Frames go through JPEG compression of this quality, 1 to 100; None: they do not.
    """

    bottom: Bottom = field(default_factory=Bottom)
    skin: Skin = field(default_factory=Skin)
    water: Water = field(default_factory=Water)
    daylight: float = 0.42
    lamps: tuple[Lamp, ...] | None = None
    clutter: float = 0.5
    companions: float = 0.0
    noise: float = 3.0
    jpeg_quality: int | None = None

    @classmethod
    def for_clutter(cls, clutter: float, noise: float) -> SceneAppearance:
        """Return the appearance of a scene between clean (0) and hardly passable (1)."""
        return cls(
            skin=Skin(tone=0.66 - 0.18 * clutter, stains=0.4 + 0.6 * clutter, cover=clutter),
            water=Water(
                absorption=0.05 + 0.2 * clutter,
                scatter=0.08 + 0.26 * clutter,
                blur=0.6 + 0.5 * clutter,
                flakes=clutter,
            ),
            clutter=clutter,
            noise=noise,
        )
