"""The filter of the thesis as users of general particle filter libraries would write it.

The models are ours, compiled: the movement and the observation of the preset `thesis`. What
differs is whose loop goes round them: `particles` of N. Chopin, or `filterpy` of R. Labbe, both
with multinomial resampling below half of the effective sample size. Neither is needed but for
comparing.

Both draw from NumPy's global random state and take no generator. It is set before and put back
after every frame, so the same seed gives the same estimates, and other code draws as before.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.measure.picture.working_image import WorkingImage, working_image_for
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.initial_state import (
    GivenState,
    draw_given_states,
    random_states,
)
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.model.statistics import cable_mean_and_covariance
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.cable.thesis.border_response_model import BorderResponseModel
from cable_tracker.cable.thesis.movement import LimitedMovement
from cable_tracker.tracking.status import TrackingStatus

SMALLEST_WEIGHT = 1e-300
"""Added to weights before they are normalised, as the manual of filterpy does."""


class CableModels:
    """The models of the preset `thesis` on one frame after the other.

    Parameters
    ----------
    parameters : TrackerParameters
        Parameters of the bootstrap filter.
    image_width : int
        Width of the frames [px].
    rng : numpy.random.Generator
        For the movement.
    """

    def __init__(
        self, parameters: TrackerParameters, image_width: int, rng: np.random.Generator
    ) -> None:
        self._movement = LimitedMovement(parameters, image_width)
        self._observation = BorderResponseModel(parameters)
        self._rng = rng
        self._image: WorkingImage | None = None
        self._dt = 0.0

    def show(self, image: WorkingImage, dt: float) -> None:
        """Go on to the next frame, `dt` seconds later."""
        self._image, self._dt = image, dt

    def moved(self, states: FloatArray) -> FloatArray:
        """Draw states (N, 8) after the time between the frames."""
        return self._movement.propagate(states, self._dt, self._rng)

    def log_likelihoods(self, states: FloatArray) -> FloatArray:
        """Return the log-likelihood (N,) of the frame."""
        assert self._image is not None
        return self._observation.log_likelihoods(states, self._image)


class LibraryLoop(Protocol):
    """A library's particle filter."""

    def step(self) -> tuple[FloatArray, FloatArray]:
        """Go on to the frame that the models show; return states (N, 8) and weights (N,)."""
        ...


class ParticlesLoop:
    """The class `SMC` of the package `particles`, fed frame by frame."""

    def __init__(self, models: CableModels, states: FloatArray) -> None:
        import particles  # noqa: PLC0415

        class Cable(particles.FeynmanKac):  # type: ignore[misc]
            """The bootstrap filter's Feynman-Kac model."""

            def M0(self, N: int) -> FloatArray:  # noqa: N802, N803
                """Return the first states."""
                return states

            def M(self, t: int, xp: FloatArray) -> FloatArray:  # noqa: N802
                """Move the states."""
                return models.moved(xp)

            def logG(self, t: int, xp: FloatArray, x: FloatArray) -> FloatArray:  # noqa: N802
                """Weigh the states."""
                return models.log_likelihoods(x)

            def done(self, smc: Any) -> bool:  # noqa: ANN401
                """Go on for ever."""
                return False

        self._smc = particles.SMC(
            fk=Cable(T=1),
            N=len(states),
            resampling="multinomial",
            ESSrmin=0.5,
            collect="off",
        )

    def step(self) -> tuple[FloatArray, FloatArray]:
        """See `LibraryLoop`."""
        next(self._smc)
        return self._smc.X, self._smc.W


class FilterpyLoop:
    """The particle filter of the manual of `filterpy`, with its function for resampling."""

    def __init__(self, models: CableModels, states: FloatArray) -> None:
        from filterpy.monte_carlo import multinomial_resample  # noqa: PLC0415

        self._resample: Callable[[FloatArray], FloatArray] = multinomial_resample
        self._models = models
        self._states = states
        self._weights = np.full(len(states), 1.0 / len(states))
        self._begun = False

    def step(self) -> tuple[FloatArray, FloatArray]:
        """See `LibraryLoop`."""
        if self._begun:
            self._go_on()
        self._begun = True
        self._weights = self._weights * np.exp(self._models.log_likelihoods(self._states))
        self._weights += SMALLEST_WEIGHT
        self._weights /= self._weights.sum()
        return self._states, self._weights

    def _go_on(self) -> None:
        if 1.0 / np.sum(self._weights**2) < len(self._weights) / 2:
            self._states = self._states[self._resample(self._weights)]
            self._weights = np.full(len(self._weights), 1.0 / len(self._weights))
        self._states = self._models.moved(self._states)


LIBRARY_LOOPS: Mapping[str, Callable[[CableModels, FloatArray], LibraryLoop]] = MappingProxyType(
    {"particles": ParticlesLoop, "filterpy": FilterpyLoop}
)
"""Loops of the filters on libraries by the name of the package."""


def is_installed(library: str) -> bool:
    """Tell whether a package can be imported."""
    return importlib.util.find_spec(library) is not None


class LibraryMethod:
    """A filter on a library as a `Method` of the evaluation. It claims a cable in every frame.

    Parameters
    ----------
    library : str
        A key of `LIBRARY_LOOPS`; it must be installed.
    """

    def __init__(self, library: str, particle_count: int, seed: int = 0) -> None:
        values = {"particle_count": particle_count, "seed": seed}
        self._parameters = preset("thesis").replaced(values)
        self._make_loop = LIBRARY_LOOPS[library]
        self._rng = np.random.default_rng(seed)
        self._global_state = np.random.RandomState(seed).get_state()
        self._prior: GivenState | None = None
        self._loop: LibraryLoop | None = None
        self._models: CableModels | None = None
        self._stamp = 0

    def initialise(self, given: GivenState) -> None:
        """Start from this cable at the next frame."""
        self._prior, self._loop = given, None

    def process(self, image: Image, stamp: int) -> CableEstimate:
        """Take a frame into account: grey uint8 of shape (H, W), and its time [ns]."""
        working = working_image_for(image, self._parameters)
        if self._loop is None or self._models is None:
            self._models = CableModels(self._parameters, image.shape[1], self._rng)
            self._loop = self._make_loop(self._models, self._first_states(image.shape[1]))
        self._models.show(working, (stamp - self._stamp) * 1e-9)
        self._stamp = stamp
        with self._own_global_state():
            states, weights = self._loop.step()
        return self._estimate(states, weights, image, stamp)

    def _first_states(self, width: int) -> FloatArray:
        if self._prior is None:
            return random_states(self._parameters, width, self._rng)
        return draw_given_states(self._prior, self._parameters, width, self._rng)

    @contextmanager
    def _own_global_state(self) -> Iterator[None]:
        before = np.random.get_state()  # noqa: NPY002
        np.random.set_state(self._global_state)  # noqa: NPY002
        try:
            yield
        finally:
            self._global_state = np.random.get_state()  # noqa: NPY002
            np.random.set_state(before)  # noqa: NPY002

    def _estimate(
        self, states: FloatArray, weights: FloatArray, image: Image, stamp: int
    ) -> CableEstimate:
        mean, covariance = cable_mean_and_covariance(states, weights)
        return CableEstimate(
            stamp=stamp,
            status=TrackingStatus.TRACKING,
            state=CableState.from_array(mean),
            covariance=covariance,
            effective_sample_size=float(1.0 / np.sum(weights**2)),
            evidence=0.0,
            image_size=(image.shape[1], image.shape[0]),
        )
