"""Scenarios: a scene, the motion of the cable in the image, and events; and the built-in ones.

S1 to S6 have the length and the frame-to-frame variances of the sequences of the thesis (Tables 4.2
and 4.3), and their characters. All but the calm S3 show an old cable, overgrown and half buried,
that is hard to tell from what lies beside it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from cable_tracker.simulation.rendering.appearance import Bottom, Lamp, SceneAppearance, Skin, Water
from cable_tracker.simulation.trajectory import Bands, Move
from cable_tracker.tracking.parameter_table import named

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


USUAL_MOTION = Motion(
    distance=ComponentMotion(0.0, 55.0, CALM),
    angle=ComponentMotion(0.0, 14.0, CALM),
    width=ComponentMotion(38.0, 7.0, CALM),
    skew=ComponentMotion(2.2, 0.9, CALM),
)

_OLD_CABLE = Skin(tone=0.58, stains=1.0, cover=0.4, turf=0.1, silt=0.1, bulge=0.07, shade=0.6)


def _frame_move(frame: int, frames: int, amount: float) -> Move:
    """Return a move that begins with a frame of a scenario and lasts some frames."""
    return Move(frame / SCENARIO_RATE, frames / SCENARIO_RATE, amount)


_STOPPING = (_frame_move(70, 25, -0.93), _frame_move(170, 25, 0.93))

_LAMP_FROM_THE_LEFT = (
    Lamp((-0.35, 0.1, 0.0), (0.0, 0.06), 0.35, 0.7),
    Lamp((0.3, 0.0, 0.0), (0.14, -0.1), 0.4, 0.3),
)

_LAMP_FROM_THE_RIGHT = (
    Lamp((0.35, 0.1, 0.0), (0.02, -0.06), 0.35, 0.7),
    Lamp((-0.3, 0.0, 0.0), (-0.1, 0.14), 0.4, 0.3),
)

_CROSSED_LAMPS = (
    Lamp((-0.3, 0.1, 0.0), (0.2, 0.14), 0.3, 0.55),
    Lamp((0.3, 0.1, 0.0), (-0.24, -0.14), 0.3, 0.55),
)
"""Cones whose rims cross the picture."""

_ALL = (
    Scenario(
        "S1",
        "much clutter; tilt and pitch waver in the first 120 frames",
        248,
        Motion(
            distance=ComponentMotion(0.0, 95.0, BRISK, 16.92),
            angle=ComponentMotion(0.0, 28.0, BRISK, 0.627, strength=(_frame_move(105, 30, -0.6),)),
            width=ComponentMotion(40.0, 14.0, BRISK, 0.26),
            skew=ComponentMotion(2.4, 2.6, BRISK, 0.008, strength=(_frame_move(105, 30, -0.75),)),
        ),
        SceneAppearance(
            bottom=Bottom(tone=0.33, stones=1.8, algae=1.4, gravel=0.5),
            skin=replace(_OLD_CABLE, cover=0.45, bulge=0.08, drift=0.28, gap_lengths=(1.5, 4.0)),
            water=Water(absorption=0.22, scatter=0.24, veil=0.28, blur=0.9, flakes=0.8),
            daylight=0.28,
            lamps=_CROSSED_LAMPS,
            clutter=0.8,
            companions=0.5,
            noise=4.0,
        ),
    ),
    Scenario(
        "S2",
        "continuous pitch oscillation; a rapid move near frame 430",
        499,
        Motion(
            distance=ComponentMotion(-15.0, 45.0, BRISK, 2.07, moves=(_frame_move(424, 14, 42.0),)),
            angle=ComponentMotion(0.0, 18.0, BRISK, 0.286, moves=(_frame_move(424, 14, -14.0),)),
            width=ComponentMotion(58.0, 36.0, ROUGH, 5.19),
            skew=ComponentMotion(3.2, 3.0, SWELL, 0.034),
        ),
        SceneAppearance(
            bottom=Bottom(tone=0.33, ripples=2.0, stones=0.6, algae=1.0, ripple_angle=6.0),
            skin=replace(_OLD_CABLE, tone=0.6, turf=0.09, drift=0.26, gap_lengths=(1.0, 3.5)),
            water=Water(absorption=0.2, scatter=0.2, veil=0.3, blur=0.9, flakes=0.7),
            daylight=0.32,
            lamps=_LAMP_FROM_THE_LEFT,
            companions=0.4,
            noise=4.0,
        ),
    ),
    Scenario(
        "S3",
        "calm",
        409,
        Motion(
            distance=ComponentMotion(8.0, 65.0, BRISK, 4.92),
            angle=ComponentMotion(2.0, 15.0, BRISK, 0.160),
            width=ComponentMotion(44.0, 18.0, BRISK, 0.51),
            skew=ComponentMotion(2.0, 1.8, BRISK, 0.004),
        ),
        SceneAppearance(
            bottom=Bottom(stones=0.7, algae=0.9),
            skin=replace(
                _OLD_CABLE, stains=0.7, cover=0.38, turf=0.07, bulge=0.05, drift=0.1, shade=0.75
            ),
            water=Water(absorption=0.13, scatter=0.15, flakes=0.3),
            clutter=0.35,
            companions=0.1,
        ),
    ),
    Scenario(
        "S4",
        "pitch moves near frames 70 and 125",
        172,
        Motion(
            distance=ComponentMotion(0.0, 60.0, BRISK, 4.93),
            angle=ComponentMotion(-4.0, 22.0, BRISK, 0.486),
            width=ComponentMotion(
                62.0,
                38.0,
                ROUGH,
                8.59,
                moves=(_frame_move(62, 18, -16.0), _frame_move(117, 18, 16.0)),
            ),
            skew=ComponentMotion(
                2.4,
                1.4,
                BRISK,
                0.009,
                moves=(_frame_move(62, 18, 1.9), _frame_move(117, 18, -1.9)),
            ),
        ),
        SceneAppearance(
            bottom=Bottom(tone=0.3, stones=2.2, gravel=0.8, algae=0.6),
            skin=replace(_OLD_CABLE, cover=0.35, turf=0.08, drift=0.25),
            water=Water(absorption=0.2, scatter=0.18, veil=0.3, blur=0.9, flakes=0.6),
            daylight=0.3,
            lamps=_LAMP_FROM_THE_RIGHT,
            companions=0.4,
            noise=4.0,
        ),
    ),
    Scenario(
        "S5",
        "a dark cable on bright ground",
        171,
        Motion(
            distance=ComponentMotion(5.0, 70.0, BRISK, 10.21),
            angle=ComponentMotion(0.0, 16.0, BRISK, 0.199),
            width=ComponentMotion(34.0, 11.0, BRISK, 0.21),
            skew=ComponentMotion(2.4, 2.6, BRISK, 0.021),
        ),
        SceneAppearance(
            bottom=Bottom(tone=0.6, ripples=2.0, stones=0.7, algae=0.6, ripple_angle=-8.0),
            skin=replace(
                _OLD_CABLE, tone=0.21, silt=0.13, drift=0.3, shade=0.5, gap_lengths=(1.5, 4.0)
            ),
            water=Water(absorption=0.12, scatter=0.22, veil=0.36, blur=0.9, flakes=0.5),
            daylight=0.45,
            lamps=_LAMP_FROM_THE_RIGHT,
            companions=0.5,
            noise=4.0,
        ),
    ),
    Scenario(
        "S6",
        "a hard move from looking down to looking forward near frame 20",
        129,
        Motion(
            distance=ComponentMotion(0.0, 75.0, BRISK, 10.31),
            angle=ComponentMotion(0.0, 24.0, BRISK, 0.599),
            width=ComponentMotion(62.0, 33.0, ROUGH, 7.50, moves=(_frame_move(16, 10, -8.0),)),
            skew=ComponentMotion(0.8, 3.4, SHAKY, 0.177, moves=(_frame_move(16, 9, 6.4),)),
        ),
        SceneAppearance(
            bottom=Bottom(tone=0.32, ripples=1.4, stones=1.2, algae=1.3),
            skin=replace(_OLD_CABLE, tone=0.57, stains=0.9, drift=0.24, shade=0.7),
            water=Water(absorption=0.18, scatter=0.18, veil=0.3, blur=0.85, flakes=0.6),
            daylight=0.32,
            lamps=_LAMP_FROM_THE_LEFT,
            companions=0.35,
            noise=3.5,
        ),
        mounting=35.0,
    ),
    Scenario(
        "leaves",
        "the cable leaves the image to the right and comes back",
        300,
        Motion(
            distance=ComponentMotion(
                20.0,
                30.0,
                CALM,
                moves=(_frame_move(90, 40, 235.0), _frame_move(190, 40, -245.0)),
            ),
            angle=ComponentMotion(0.0, 8.0, CALM),
            width=ComponentMotion(38.0, 6.0, CALM),
            skew=ComponentMotion(2.0, 0.8, CALM),
        ),
    ),
    Scenario(
        "buried",
        "all of the cable in view is buried for 3 s",
        300,
        # A steady view and little else on the cable: it goes and comes back at the sand's edge.
        replace(
            USUAL_MOTION,
            width=ComponentMotion(38.0, 4.0, CALM),
            skew=ComponentMotion(2.2, 0.3, CALM),
            speed=0.7,
        ),
        SceneAppearance(skin=Skin(cover=0.15)),
        buried=(110, 184),
    ),
    Scenario(
        "crossing",
        "a second cable lies across the first",
        250,
        USUAL_MOTION,
        crossing=Crossing(frame=120),
    ),
    Scenario(
        "no_cable",
        "no cable at all, but ropes and tracks",
        250,
        USUAL_MOTION,
        SceneAppearance(clutter=1.0),
        has_cable=False,
    ),
    Scenario(
        "decoys",
        "no cable, but trenches and pairs of parallel lines that look like one",
        250,
        USUAL_MOTION,
        SceneAppearance(clutter=1.0, companions=0.8),
        has_cable=False,
    ),
    Scenario(
        "night",
        "no light but one narrow lamp",
        250,
        USUAL_MOTION,
        SceneAppearance(
            water=Water(absorption=0.28, scatter=0.22, veil=0.16, flakes=0.9),
            daylight=0.012,
            lamps=(Lamp((0.18, 0.05, 0.0), (-0.12, 0.06), 0.28, 1.6),),
            noise=4.5,
            jpeg_quality=70,
        ),
    ),
    Scenario(
        "stop",
        "the vehicle stops over the cable for 3 s",
        250,
        Motion(
            distance=ComponentMotion(10.0, 45.0, CALM, strength=_STOPPING),
            angle=ComponentMotion(0.0, 12.0, CALM, strength=_STOPPING),
            width=ComponentMotion(40.0, 6.0, CALM, strength=_STOPPING),
            skew=ComponentMotion(2.2, 0.8, CALM, strength=_STOPPING),
            stop=(95, 170),
        ),
    ),
)

SCENARIOS: Mapping[str, Scenario] = MappingProxyType({each.name: each for each in _ALL})
"""All scenarios by name."""


def find_scenario(name: str) -> Scenario:
    """Return the scenario of a name.

    Raises
    ------
    ParameterError
        There is none.
    """
    return named("scenario", name, SCENARIOS)
