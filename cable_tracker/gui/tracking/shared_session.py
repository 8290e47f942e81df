"""The session that all browsers of one server watch, and its pictures."""

from __future__ import annotations

import threading
from collections.abc import Mapping

import numpy as np

from cable_tracker.cable.model.geometry import wrap_state
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.state import STATE_SIZE, CableState
from cable_tracker.errors import FrameError, GuiError
from cable_tracker.gui.session.recording_session import RecordingRequest, RecordingSession
from cable_tracker.gui.session.session import CableSnapshot, Session, TargetSnapshot
from cable_tracker.gui.subject import CABLE, TARGET
from cable_tracker.gui.tracking.picture_feed import PictureFeed
from cable_tracker.target.model.estimate import Box
from cable_tracker.target.model.start import TargetStart
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.tracking.image_frame import from_page
from cable_tracker.tracking.parameter_table import ParameterSet, ParameterValue

Point = tuple[float, float]


class SharedSession:
    """Holds the session that all browsers watch; another recording can take its place.

    Parameters
    ----------
    request : RecordingRequest
        Settings with which recordings are opened from the page; its path is replaced.
    parameters : TrackerParameters or TargetParameters
        For the first recording that is opened from the page; they say what is followed there.

    Attributes
    ----------
    session : Session or None
        None until one is watched.
    feed : PictureFeed
        Pictures for all browsers.
    subject : Subject
        Description of the tracked object; the same in every session.
    references : dict
        Presets and files that were read, values by name.
    version : int
        Changes with the session.
    """

    def __init__(self, request: RecordingRequest, parameters: ParameterSet) -> None:
        self.session: Session | None = None
        self.request = request
        self._parameters = parameters
        self.subject = TARGET if isinstance(parameters, TargetParameters) else CABLE
        self.references: dict[str, Mapping[str, ParameterValue]] = {}
        self.references |= self.subject.references()
        self.version = 0
        self.feed = PictureFeed()
        self._lock = threading.Lock()

    @property
    def player(self) -> RecordingSession | None:
        """The session if it is on a recording."""
        return self.session if isinstance(self.session, RecordingSession) else None

    def present_state(self) -> CableState | None:
        """Return the newest estimate; None while no cable is claimed."""
        latest = self.session.latest if self.session is not None else None
        return latest.row.state if isinstance(latest, CableSnapshot) else None

    def present_box(self) -> Box | None:
        """Return the newest box; None while no target is claimed."""
        latest = self.session.latest if self.session is not None else None
        claim = latest.row.claim if isinstance(latest, TargetSnapshot) else None
        return claim.box if claim is not None else None

    def need_session(self) -> Session:
        """Return the session.

        Raises
        ------
        GuiError
            There is none yet.
        """
        if self.session is None:
            raise GuiError("no recording is open; open one first")
        return self.session

    def watch(self, session: Session) -> None:
        """Watch a session instead of what is watched now."""
        before, self.session = self.session, session
        self.feed.watch(session)
        self.version += 1
        if before is not None:
            before.close()

    def open(self, request: RecordingRequest) -> None:
        """Watch a recording instead of what is watched now, with the same parameters.

        Raises
        ------
        CableTrackerError
            It cannot be opened; all stays as it is.
        """
        with self._lock:
            if self.session is not None:
                values = self.session.parameters()
                self._parameters = self.subject.kind.with_values("default", values)
            self.watch(RecordingSession(request, self._parameters))
            self.request = request

    def close(self) -> None:
        """End everything."""
        self.feed.close()
        if self.session is not None:
            self.session.close()


def drawn_state(start: Point, end: Point, width: float, size: tuple[int, int]) -> CableState:
    """Return the cable along a line that was drawn on a picture.

    Parameters
    ----------
    start, end : (float, float)
        Points of its centreline, from the upper left corner, y down [px].
    width : float
        Width of the cable [px].
    size : (int, int)
        Width and height of the picture [px].
    """
    x, y = from_page(*start, size)
    along_x, along_y = end[0] - start[0], start[1] - end[1]
    angle = np.arctan2(-along_x, along_y)
    values = np.zeros(STATE_SIZE)
    values[:3] = x * np.cos(angle) + y * np.sin(angle), angle, width
    return CableState.from_array(wrap_state(values))


def start_at(session: Session, state: CableState) -> None:
    """Start from where the user says the cable is.

    Raises
    ------
    FrameError
        The state is not finite, or its width is not positive.
    """
    if state.width <= 0.0:
        raise FrameError(f"w = {state.width:g} px is no width of a cable; give a positive one")
    session.initialise(GivenState.around(state))


def start_with_box(session: Session, first: Point, second: Point) -> None:
    """Follow what is in a box.

    Parameters
    ----------
    session : Session
        On a target.
    first, second : (float, float)
        Opposite corners, from the upper left corner of the picture, y down [px].

    Raises
    ------
    FrameError
        The box has no area, or lies outside the picture.
    """
    (left, right), (top, bottom) = (sorted(pair) for pair in zip(first, second, strict=True))
    session.initialise(TargetStart.from_box(left, top, right, bottom))
