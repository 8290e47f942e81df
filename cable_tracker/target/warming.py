"""Compiles and loads the machine code of a target tracker before frames come."""

from __future__ import annotations

import numpy as np

from cable_tracker.target.model.start import TargetStart
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.tracker import TargetTracker

WIDTH, HEIGHT = 320, 240
FRAMES = 3
STEP = 40_000_000
"""Size of the frames [px], how many, and the time between them [ns]."""

WARM_UP_PARTICLES = 60
"""Number of particles of a warm-up; compilation does not depend on it."""

WATER, TARGET = (90, 80, 40), (30, 30, 200)
"""Colours [blue, green, red]."""


def warm_up_target(parameters: TargetParameters) -> None:
    """Run trackers of its own on a few frames, in colour and in grey.

    The first time on a machine takes some seconds or more; later the machine code is on disk.
    """
    few = parameters.replaced({"particle_count": min(parameters.particle_count, WARM_UP_PARTICLES)})
    picture = np.full((HEIGHT, WIDTH, 3), WATER, np.uint8)
    picture[90:150, 120:200] = TARGET
    for frame in (picture, np.ascontiguousarray(picture[..., 2])):
        # Frames of messages cannot be written to, and are compiled for as another type.
        frame.setflags(write=False)
        tracker = TargetTracker(few)
        tracker.process(frame, stamp=STEP)
        tracker.initialise(TargetStart.from_box(120, 90, 200, 150))
        for number in range(2, FRAMES + 2):
            tracker.process(frame, stamp=number * STEP)
