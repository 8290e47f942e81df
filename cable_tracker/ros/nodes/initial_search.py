"""Start of a node's tracking: at random, at a given state, or at a detection."""

from __future__ import annotations

from cable_tracker.arrays import Image
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.initial_state_text import parse_initial_state
from cable_tracker.detection.baselines.detectors import DETECTORS
from cable_tracker.detection.detector import CableDetector
from cable_tracker.detection.line_pairs import DEFAULT_LIMITS, PairLimits
from cable_tracker.errors import ParameterError


class InitialSearch:
    """Gives the prior that the parameter `initial_state` names.

    Parameters
    ----------
    text : str
        ``random``, ``d,alpha,w,beta`` in px and rad, or the name of a detector.
    limits : PairLimits
        Widths and skews of the cables that the detector looks for.

    Attributes
    ----------
    is_seeking : bool
        Whether the detector has yet to find a cable.

    Raises
    ------
    ParameterError
        The text is none of these.
    """

    def __init__(self, text: str, limits: PairLimits = DEFAULT_LIMITS) -> None:
        self._detector: CableDetector | None = None
        self._given: GivenState | None = None
        self.is_seeking = False
        self._name = text.strip()
        if self._name in DETECTORS:
            self.limit(limits)
            return
        try:
            state = parse_initial_state(text)
        except ParameterError as error:
            raise ParameterError(f"{error}, nor a detector ({', '.join(DETECTORS)})") from error
        self._given = GivenState.around(state) if state is not None else None

    def limit(self, limits: PairLimits) -> None:
        """Let the detector, if there is one, look for cables of other widths and skews."""
        if self._name in DETECTORS:
            self._detector = DETECTORS[self._name](limits)

    def changed_to(self, text: str, limits: PairLimits) -> InitialSearch:
        """Return the search for another text: this one for the same; another detector seeks on.

        Parameters
        ----------
        text : str
            As of the constructor.
        limits : PairLimits
            As of the constructor.

        Raises
        ------
        ParameterError
            The text is none of those.
        """
        if text.strip() == self._name:
            return self
        changed = InitialSearch(text, limits)
        changed.is_seeking = self.is_seeking and changed._detector is not None
        return changed

    def restart(self) -> GivenState | None:
        """Begin anew; return the prior of the next frame, None where none is known yet."""
        self.is_seeking = self._detector is not None
        return self._given

    def stop(self) -> None:
        """Seek no more: the filter has found a cable by itself, or was given where one is."""
        self.is_seeking = False

    def detect(self, picture: Image) -> GivenState | None:
        """Return the prior of a detected cable, and seek no more; None where none is detected.

        Call it while `is_seeking`.

        Parameters
        ----------
        picture : Image
            Grey levels, shape (H, W).

        Raises
        ------
        FrameError
            The picture cannot be used.
        """
        assert self._detector is not None
        found = self._detector.detect(picture)
        if not found:
            return None
        self.is_seeking = False
        return GivenState.around(found[0].state, is_guess=True)
