from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from cable_tracker.cable.model.state import CableState
from cable_tracker.metric.cable_instrument_fusion import CableInstrumentFusion
from cable_tracker.metric.ground_view import PlaneMotion
from cable_tracker.metric.odometry.aiding import CALM_FRAMES, FEWEST, AgreementGate, MotionAiding
from cable_tracker.metric.odometry.motion import (
    CABLE_DISAGREES,
    NOT_PROVED,
    TEXTURE_DISAGREES,
    Odometry,
)
from cable_tracker.metric.odometry.sea_bed_texture import CALM_PICTURES, SeaBedTexture
from cable_tracker.node_parameter_tables import CableVehicleParameters
from cable_tracker.tracking.status import TrackingStatus

SECOND = 1_000_000_000
FRAME = SECOND // 25
PROVED = CALM_FRAMES + FEWEST + 1
"""The frame in which sound odometry is used for the first time, counted from 1."""

UNKNOWN = np.array([0.36, 1e-5])
OBSERVED = np.array([1.0, 1e-4])


class Drive:
    """A vehicle 1.4 m above a cable that it slides off sideways, with a camera that looks down."""

    BARE = np.full((240, 320), 90, np.uint8)
    SWAY = 0.2
    PIXELS_A_FRAME = SWAY * 280.0 / 1.4 / 25

    def __init__(self, calibration, make_estimate):
        fusion = CableInstrumentFusion(CableVehicleParameters(fixed_altitude=1.4), calibration)
        self.odometry = Odometry()
        self.aiding = MotionAiding(fusion.ground_view, self.odometry)
        self._make_estimate = make_estimate
        self._frame = 0
        self._twists = 0

    def hears(self, sway):
        """Odometry up to the next frame: a velocity to the left, which moves the cable right."""
        while self._twists * SECOND // 50 <= (self._frame + 1) * FRAME:
            wobble = 1e-4 * (-1) ** self._twists
            twist = np.array([0.0, sway + wobble, 0.0, 0.0, 0.0, 0.0])
            self.odometry.add(SECOND + self._twists * SECOND // 50, twist, np.eye(6) * 1e-6)
            self._twists += 1

    def sees(self, status=TrackingStatus.TRACKING, moving=1.0, bottom=BARE) -> PlaneMotion | None:
        """Return what the filter would be told, and show where the cable really is."""
        stamp = SECOND + self._frame * FRAME
        motion = self.aiding.motion(stamp, bottom)
        distance = -60.0 + moving * self.PIXELS_A_FRAME * self._frame
        state = CableState(distance, 0.0, 40.0)
        self.aiding.observe(
            self._make_estimate(state, (1.0, 0.01, 1.0, 0.01), status=status, stamp=stamp)
        )
        self._frame += 1
        return motion


@pytest.fixture
def drive(calibrations, make_estimate):
    return Drive(calibrations["pinhole"], make_estimate)


def test_a_sway_to_the_left_moves_the_cable_to_the_right(drive):
    for _ in range(PROVED):
        drive.hears(Drive.SWAY)
        motion = drive.sees()
    moved = motion.moved(np.array([[10.0, 0.0, 40.0, 0.0, 0.0, 0.0, 0.0, 0.0]]))[0]
    assert moved[0] - 10.0 == pytest.approx(Drive.PIXELS_A_FRAME, rel=0.02)
    assert drive.aiding.unaided is None


def test_sound_odometry_is_used_once_it_has_proved_itself(drive):
    used = []
    for _ in range(2 * PROVED):
        drive.hears(Drive.SWAY)
        used.append(drive.sees() is not None)
    assert used == [False] * (PROVED - 1) + [True] * (PROVED + 1)


@pytest.mark.parametrize("said", [0.0, -Drive.SWAY, 1.0])
def test_wrong_odometry_is_told_from_sound_one(drive, said):
    for _ in range(20):
        drive.hears(said)
        motion = drive.sees()
    assert motion is None
    assert drive.aiding.unaided == CABLE_DISAGREES


def test_odometry_that_is_sound_again_is_used_again(drive):
    for _ in range(20):
        drive.hears(0.0)
        drive.sees()
    used = []
    for _ in range(60):
        drive.hears(Drive.SWAY)
        used.append(drive.sees() is not None)
    assert not used[0] and used[-1]


def test_silent_odometry_is_told(drive):
    drive.hears(Drive.SWAY)
    for _ in range(12):
        motion = drive.sees()
    assert motion is None
    assert "older than the image" in drive.aiding.unaided.why


def test_without_a_claim_nothing_is_judged(drive):
    for _ in range(30):
        drive.hears(-Drive.SWAY)
        drive.sees(TrackingStatus.LOST)
    assert drive.aiding.unaided == NOT_PROVED


def test_without_altitude_there_is_no_aid(make_estimate, calibrations):
    fusion = CableInstrumentFusion(CableVehicleParameters(), calibrations["pinhole"])
    drive = Drive(calibrations["pinhole"], make_estimate)
    drive.aiding = MotionAiding(fusion.ground_view, drive.odometry)
    for _ in range(3):
        drive.hears(0.1)
        drive.sees()
    assert "no altitude" in drive.aiding.unaided.why


def test_longer_steps_leave_more_unknown(drive):
    sigmas = []
    for _ in range(PROVED):
        drive.hears(Drive.SWAY)
        drive.sees()
    for skipped in (1, 4):
        drive._frame += skipped - 1
        drive.hears(Drive.SWAY)
        drive.sees()
        drive._frame += skipped - 1
        drive.hears(Drive.SWAY)
        motion = drive.sees()
        sigmas.append(motion.scales()[0])
    assert sigmas[1] == pytest.approx(sigmas[0] * math.sqrt(4), rel=0.1)


@pytest.mark.parametrize("refusal", [cv2.error("bad argument"), np.linalg.LinAlgError("singular")])
def test_without_a_comparison_there_is_no_aid_and_the_reason_is_told(drive, monkeypatch, refusal):
    def refuse(*_, **__):
        raise refusal

    for _ in range(PROVED):
        drive.hears(Drive.SWAY)
        drive.sees()
    monkeypatch.setattr(SeaBedTexture, "compare", refuse)
    drive.hears(Drive.SWAY)
    assert drive.sees() is None
    assert str(refusal) in drive.aiding.unaided.why
    monkeypatch.undo()
    drive.hears(Drive.SWAY)
    assert drive.sees() is not None


class TestWithTexture:
    """The bottom shows how the vehicle moves, also where no cable is claimed."""

    @pytest.fixture
    def bottom(self, drive):
        noise = np.random.default_rng(3).normal(0.0, 1.0, (240, 400))
        wide = np.clip(110.0 + 400.0 * cv2.GaussianBlur(noise, (0, 0), 2.5), 0, 255)

        def at(frame):
            shift = np.array([[1.0, 0.0, drive.PIXELS_A_FRAME * frame - 60.0], [0.0, 1.0, 0.0]])
            return cv2.warpAffine(wide, shift, (320, 240)).astype(np.uint8)

        return at

    @staticmethod
    def driven(drive, bottom, said, frames, first=0):
        used = []
        for frame in range(first, first + frames):
            drive.hears(said)
            used.append(drive.sees(TrackingStatus.LOST, bottom=bottom(frame)))
        return used

    def test_sound_odometry_is_used_at_once(self, drive, bottom):
        used = self.driven(drive, bottom, Drive.SWAY, 4)
        assert [motion is not None for motion in used] == [False, True, True, True]
        assert drive.aiding.texture_motion.error < 0.3

    def test_no_picture_is_looked_at_before_odometry_has_come_but_the_last_is_kept(
        self, drive, bottom, monkeypatch
    ):
        with monkeypatch.context() as without:
            without.delattr(SeaBedTexture, "compare")
            for frame in range(3):
                assert drive.sees(TrackingStatus.LOST, bottom=bottom(frame)) is None
        assert drive.aiding.unaided.why == "no odometry has come"
        # Twists of before, late on the way: the first frame after them is compared already.
        (used,) = self.driven(drive, bottom, Drive.SWAY, 1, first=3)
        assert used is not None
        assert drive.aiding.texture_motion.error < 0.3

    @pytest.mark.parametrize("said", [-Drive.SWAY, 1.0])
    def test_wrong_odometry_is_never_used_and_told(self, drive, bottom, said):
        assert self.driven(drive, bottom, said, 12) == [None] * 12
        assert drive.aiding.unaided == TEXTURE_DISAGREES

    def test_odometry_that_goes_wrong_is_dropped_at_once(self, drive, bottom):
        self.driven(drive, bottom, Drive.SWAY, 10)
        used = self.driven(drive, bottom, 3.0, 6, first=10)
        # What is heard first is of the frame after next.
        assert used[1:] == [None] * 5

    def test_what_the_bottom_shows_to_be_off_counts_as_unknown(self, drive, bottom):
        drive.PIXELS_A_FRAME = 8.0
        sigmas = [
            self.driven(drive, bottom, said, 3, first=drive._frame)[-1].pose_sigmas
            for said in (1.0, 1.3)
        ]
        assert (sigmas[1] > 1.5 * sigmas[0]).all()

    def test_looks_at_it_may_rest_while_it_agrees(self, drive, bottom, monkeypatch):
        drive.aiding._texture_pause = 10 * FRAME
        looks = []
        compare = SeaBedTexture.compare

        def counted(*given):
            looks.append(drive._frame)
            return compare(*given)

        monkeypatch.setattr(SeaBedTexture, "compare", counted)
        used = self.driven(drive, bottom, Drive.SWAY, 40)
        assert all(motion is not None for motion in used[2:])
        assert len(looks) < 10

    def test_it_is_looked_at_in_every_frame_once_it_has_ceased_to_agree(self, drive, bottom):
        drive.aiding._texture_pause = 10 * FRAME
        self.driven(drive, bottom, Drive.SWAY, 12)
        used = self.driven(drive, bottom, 3.0, 30, first=12)
        assert used[12:] == [None] * 18
        used = self.driven(drive, bottom, Drive.SWAY, CALM_PICTURES + 4, first=42)
        assert used[-1] is not None

    def test_a_frame_that_was_overtaken_changes_nothing(self, drive, bottom):
        self.driven(drive, bottom, Drive.SWAY, 4)
        late = SECOND + 2 * FRAME
        assert drive.aiding.motion(late, bottom(0)) is None
        used = self.driven(drive, bottom, Drive.SWAY, 2, first=4)
        assert all(motion is not None for motion in used)
        assert drive.aiding.texture_motion.error < 0.3


def shown(gate, residuals):
    for residual in residuals:
        gate.compare(np.array([residual, 0.0]), UNKNOWN, OBSERVED)
    return gate


@pytest.fixture
def proved() -> AgreementGate:
    """A gate that has seen enough agreement to be open."""
    gate = shown(AgreementGate(), [0.1, -0.1] * (CALM_FRAMES + FEWEST))
    assert gate.doubt is None
    return gate


def test_odometry_has_to_prove_itself():
    gate = AgreementGate()
    assert gate.disagreement() is None
    assert gate.doubt == NOT_PROVED
    shown(gate, [0.1, -0.1] * ((CALM_FRAMES + FEWEST - 2) // 2))
    assert gate.doubt is not None
    assert shown(gate, [0.1, -0.1]).doubt is None


def test_noise_does_not_close_the_gate(proved):
    rng = np.random.default_rng(1)
    for residual in rng.normal(0.0, 0.6, 2000):
        assert shown(proved, [residual]).doubt is None


def test_a_drift_closes_the_gate(proved):
    assert shown(proved, [1.1] * 12).doubt == CABLE_DISAGREES


def test_a_motion_to_and_fro_that_is_missed_closes_the_gate(proved):
    assert shown(proved, [2.0, -2.0] * 6).doubt is not None


def test_a_jump_of_the_filter_does_not_close_the_gate(proved):
    assert shown(proved, [60.0] + [0.1, -0.1] * 10).doubt is None


def test_a_drift_of_the_angle_closes_the_gate_too(proved):
    for _ in range(12):
        proved.compare(np.array([0.0, 0.02]), UNKNOWN, OBSERVED)
    assert proved.doubt is not None


def test_the_gate_opens_again_after_long_agreement(proved):
    shown(proved, [2.5] * 12)
    assert shown(proved, [0.1, -0.1] * (CALM_FRAMES // 2)).doubt is not None
    assert shown(proved, [0.1, -0.1] * CALM_FRAMES).doubt is None


def test_drift_does_not_add_up_across_a_gap(proved):
    proved.interrupt()
    shown(proved, [2.5] * (FEWEST - 1))
    proved.interrupt()
    assert shown(proved, [2.5] * (FEWEST - 1)).doubt is None
