"""The methods that are compared, behind one interface.

The measurement noise of each detector, like all constants of the baselines, was chosen on simulated
dives of the seeds 100 to 109; report results on other seeds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Protocol

from cable_tracker.arrays import Image
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.parameters.presets import PRESETS, preset
from cable_tracker.detection.baselines.detectors import DETECTORS
from cable_tracker.evaluation.baselines import DetectorTracker, FourSigmas, KalmanNoise
from cable_tracker.trackers import make_tracker


class Method(Protocol):
    """Tracks one cable through a sequence of frames, as `CableTracker` does."""

    def initialise(self, given: GivenState) -> None:
        """Start from this cable at the next frame."""
        ...

    def process(self, image: Image, stamp: int) -> CableEstimate:
        """Take a frame into account.

        Grey levels 0..255, uint8 or float32, of shape (H, W), and its time [ns].
        """
        ...


@dataclass(frozen=True, slots=True)
class MethodSpec:
    """One method.

    Attributes
    ----------
    name : str
        Name in reports and on the command line.
    description : str
        Description in a few words.
    make : callable
        Makes a fresh tracker from a seed. The same seed gives the same results; methods without
        random numbers do not mind it.
    """

    name: str
    description: str
    make: Callable[[int], Method]


@dataclass(frozen=True, slots=True)
class ConfiguredFilter:
    """The tracker of this project with parameters of one's own. It is sent to other processes.

    Attributes
    ----------
    name : str
        Name of the method in results.
    parameters : TrackerParameters
        All of them; the seed is that of the run.
    """

    name: str
    parameters: TrackerParameters

    def make(self, seed: int) -> Method:
        """Make a fresh tracker from a seed."""
        return make_tracker(self.parameters.replaced({"seed": seed}))


def _particle_filter(name: str, description: str) -> MethodSpec:
    return MethodSpec(name, description, ConfiguredFilter(name, preset(name)).make)


def _detector(name: str, description: str, measurement: FourSigmas) -> MethodSpec:
    noise = KalmanNoise(measurement)
    return MethodSpec(name, description, lambda _seed: DetectorTracker(DETECTORS[name](), noise))


METHODS: Mapping[str, MethodSpec] = MappingProxyType(
    {
        spec.name: spec
        for spec in (
            _particle_filter("default", "particle filter of this project"),
            _particle_filter("thesis", "particle filter with the parameters of Wirth's thesis"),
            _detector(
                "hough",
                "Laplacian of Gaussian, Hough lines, Kalman filter (Matsumoto and Ito 1995)",
                (1.0, 0.5, 2.0, 0.5),
            ),
            _detector(
                "segmentation",
                "histogram segmentation, contours, Kalman filter (Antich and Ortiz 2003)",
                (1.2, 0.7, 2.2, 0.7),
            ),
            _detector(
                "lsd",
                "line segment detector of OpenCV, Kalman filter (Grompone von Gioi et al. 2010)",
                (1.0, 0.5, 2.0, 0.5),
            ),
            _detector(
                "texture",
                "texture descriptors of cells, Kalman filter (Grau et al. 1998)",
                (1.0, 0.8, 2.0, 0.8),
            ),
        )
    }
)
"""All methods by name."""

BASELINES: tuple[str, ...] = tuple(name for name in METHODS if name not in PRESETS)
"""Methods that are not filters of this project."""
