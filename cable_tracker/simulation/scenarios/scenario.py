"""Description of a scenario: a scene, the motion of the cable in the image, and events."""

from __future__ import annotations

from dataclasses import dataclass, field

from cable_tracker.simulation.motion.trajectory import Bands, Move
from cable_tracker.simulation.rendering.appearance import SceneAppearance, Skin

SCENARIO_RATE = 25.0
"""Frames per second of all scenarios."""

CALM: Bands = ((0.12, 0.2), (0.3, 0.45), (0.6, 0.8))
BRISK: Bands = ((0.25, 0.4), (0.5, 0.7), (0.9, 1.2))
ROUGH: Bands = ((0.5, 0.7), (0.9, 1.2), (1.5, 1.9))
SHAKY: Bands = ((0.8, 1.0), (1.3, 1.6), (1.9, 2.3))
SWELL: Bands = ((0.45, 0.55), (1.0, 1.3))
"""Frequency bands of a cable's oscillation in the image [Hz]."""


@dataclass(frozen=True, slots=True)
class ComponentMotion:
    """Motion of one of d, alpha, w, beta; lengths in px at a width of 320, angles in degrees.

    Attributes
    ----------
    mean : float
        Initial value.
    limit : float
        The oscillation stays within +-limit.
    bands : Bands
        Frequencies of the oscillation.
    variance : float or None
        Wanted variance of the steps from frame to frame [px² or deg²]; None: the oscillation takes
        all of its limit.
    moves : tuple of Move
        Besides the oscillation.
    strength : tuple of Move
        Changes of the strength of the oscillation, which starts at 1.
    """

    mean: float
    limit: float
    bands: Bands = BRISK
    variance: float | None = None
    moves: tuple[Move, ...] = ()
    strength: tuple[Move, ...] = ()


@dataclass(frozen=True, slots=True)
class Motion:
    """Motion of the cable in the image.

    Attributes
    ----------
    distance, width : ComponentMotion
        d and w [px at a width of 320].
    angle, skew : ComponentMotion
        alpha and beta [deg].
    speed : float
        Along the cable [m/s].
    stop : (int, int) or None
        First and last frame between which the vehicle stands still.
    """

    distance: ComponentMotion
    angle: ComponentMotion
    width: ComponentMotion
    skew: ComponentMotion
    speed: float = 0.35
    stop: tuple[int, int] | None = None


@dataclass(frozen=True, slots=True)
class Crossing:
    """A second cable that lies over the first.

    Attributes
    ----------
    frame : int
        Frame at which the crossing is in the middle of the view.
    angle : float
        Between the two cables [deg].
    radius : float
        [m].
    skin : Skin
        Surface of the crossing cable.
    """

    frame: int
    angle: float = 52.0
    radius: float = 0.06
    skin: Skin = field(default_factory=lambda: Skin(tone=0.5, cover=0.3))


@dataclass(frozen=True, slots=True)
class Scenario:
    """A scene and what happens in it.

    Attributes
    ----------
    name : str
        Name in the table of scenarios.
    description : str
        Difficulty of the scenario, in a few words.
    frame_count : int
        Number of frames, at 25 frames per second.
    motion : Motion
        Motion of the cable in the image.
    appearance : SceneAppearance
        Appearance of the scene.
    curvature : float
        The cable never bends more than this [1/m].
    mounting : float
        Forward tilt of the camera on the vehicle [deg].
    has_cable : bool
        Whether there is any.
    buried : (int, int) or None
        First and last frame of those in which all of the cable in view is buried.
    crossing : Crossing or None
        A second cable.
    """

    name: str
    description: str
    frame_count: int
    motion: Motion
    appearance: SceneAppearance = field(default_factory=SceneAppearance)
    curvature: float = 0.012
    mounting: float = 20.0
    has_cable: bool = True
    buried: tuple[int, int] | None = None
    crossing: Crossing | None = None
