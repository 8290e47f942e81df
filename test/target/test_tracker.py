import math
from itertools import islice

import cv2
import numpy as np
import pytest

from cable_tracker.errors import FrameError
from cable_tracker.simulation.targets.sequence import simulate_target
from cable_tracker.target.measure.outline import Outline
from cable_tracker.target.model.camera_motion import CameraMotion
from cable_tracker.target.model.start import TargetStart
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.tracker import TargetTracker
from cable_tracker.tracking.image_frame import bounding_box
from cable_tracker.tracking.status import TrackingStatus

STEP = 40_000_000


def overlap(one, two):
    width = min(one[2], two[2]) - max(one[0], two[0])
    height = min(one[3], two[3]) - max(one[1], two[1])
    if min(width, height) <= 0:
        return 0.0
    both = width * height
    areas = [(box[2] - box[0]) * (box[3] - box[1]) for box in (one, two)]
    return both / (sum(areas) - both)


def started(draw, seed=1, **options):
    tracker = TargetTracker(TargetParameters(seed=seed))
    image, mask = draw(**options)
    tracker.initialise(TargetStart.from_box(*bounding_box(mask)))
    return tracker, tracker.process(image, STEP)


def test_a_marked_target_is_claimed_at_once(draw):
    _, estimate = started(draw)
    assert estimate.status.value == "TRACKING"
    assert overlap(estimate.box, bounding_box(draw()[1])) > 0.85
    assert estimate.scale == 1.0
    assert estimate.is_whole


def test_the_estimate_follows_position_size_and_rates(draw):
    tracker, _ = started(draw, centre=(80, 60))
    for number in range(2, 30):
        centre, axes = (80 + 4 * number, 60 + 2 * number), (22 + number // 2, 14 + number // 3)
        image, mask = draw(centre=centre, axes=axes, seed=number)
        estimate = tracker.process(image, number * STEP)
        assert overlap(estimate.box, bounding_box(mask)) > 0.7
    assert estimate.state[:2] == pytest.approx([centre[0] - 159.5, 119.5 - centre[1]], abs=3.0)
    assert estimate.scale == pytest.approx(np.sqrt(36 * 23 / (22 * 14)), rel=0.15)
    assert estimate.state[4] > 40.0
    assert estimate.state[5] < -10.0


def test_the_same_seed_gives_the_same_estimates(draw):
    def last(seed):
        tracker, _ = started(draw, seed)
        for number in range(2, 6):
            image, _ = draw(centre=(160 + 3 * number, 120), seed=number)
            estimate = tracker.process(image, number * STEP)
        return estimate

    np.testing.assert_array_equal(last(7).state, last(7).state)
    assert (last(7).state != last(8).state).any()


def test_a_copy_goes_on_alike_and_apart(draw):
    tracker, _ = started(draw)
    twin = tracker.copy()
    image, _ = draw(centre=(165, 120), seed=2)
    ours, theirs = tracker.process(image, 2 * STEP), twin.process(image, 2 * STEP)
    np.testing.assert_array_equal(ours.state, theirs.state)
    tracker.process(draw(centre=(170, 120), seed=3)[0], 3 * STEP)
    assert twin.process(image, 3 * STEP).status.value == "TRACKING"


def test_what_is_gone_is_not_claimed_and_found_again(draw):
    tracker, _ = started(draw)
    for number in range(2, 12):
        tracker.process(draw(seed=number)[0], number * STEP)
    for number in range(12, 24):
        estimate = tracker.process(draw(centre=None, seed=number)[0], number * STEP)
    assert estimate.status.value == "LOST"
    assert estimate.presence < 0.1
    for number in range(24, 40):
        estimate = tracker.process(draw(centre=(180, 110), seed=number)[0], number * STEP)
    assert estimate.status.value == "TRACKING"
    assert overlap(estimate.box, bounding_box(draw(centre=(180, 110))[1])) > 0.7


def test_grey_pictures_do_as_well(draw):
    tracker = TargetTracker(TargetParameters(seed=1))
    _, mask = draw()
    tracker.initialise(TargetStart.from_box(*bounding_box(mask)))
    for number in range(1, 15):
        image, mask = draw(centre=(160 + 3 * number, 120), seed=number, colour=(20, 20, 25))
        if number == 1:
            tracker.initialise(TargetStart.from_box(*bounding_box(mask)))
        grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
        estimate = tracker.process(grey, number * STEP)
    assert overlap(estimate.box, bounding_box(mask)) > 0.6


def share_on_its_own(seed, frames=50):
    """Of the frames of a grey run with a twin, before they meet."""
    tracker = TargetTracker(TargetParameters(seed=seed))
    own = []
    for frame in islice(simulate_target("crossing", seed), frames):
        if not own:
            tracker.initialise(TargetStart.from_box(*frame.box))
        grey = cv2.cvtColor(frame.image, cv2.COLOR_BGR2GRAY)
        estimate = tracker.process(grey, frame.stamp)
        own.append(
            estimate.box is not None
            and overlap(estimate.box, frame.box) > overlap(estimate.box, frame.twin_box)
        )
    return np.mean(own)


def test_a_twin_elsewhere_does_not_take_the_target_over():
    assert np.mean([share_on_its_own(seed) for seed in (101, 108)]) > 0.75


def test_colour_that_becomes_grey_is_no_loss(draw):
    tracker, _ = started(draw, colour=(20, 20, 30))
    for number in range(2, 12):
        image, mask = draw(centre=(160 + 2 * number, 120), seed=number, colour=(20, 20, 30))
        if number > 4:
            image = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
        estimate = tracker.process(image, number * STEP)
    assert estimate.status.value == "TRACKING"
    assert overlap(estimate.box, bounding_box(mask)) > 0.5


def even(centre=None, noise=0.0):
    """A red ellipse, all that has colour, in grey water."""
    picture = np.full((240, 320, 3), 110, np.uint8)
    if centre is not None:
        cv2.ellipse(picture, centre, (22, 14), 0, 0, 360, (30, 30, 200), -1)
    greys = np.random.default_rng(7).normal(0.0, noise, (240, 320, 1)) if noise else 0.0
    return np.clip(picture + greys, 0, 255).astype(np.uint8)


@pytest.mark.parametrize("noise", [0.0, 4.0])
def test_water_without_colour_is_not_a_hidden_target_that_had_all_of_it(noise):
    tracker = TargetTracker(TargetParameters(seed=1))
    tracker.initialise(TargetStart.from_box(138, 106, 183, 135))
    for number in range(1, 20):
        estimate = tracker.process(even((160, 120), noise), number * STEP)
    assert estimate.status.value == "TRACKING"
    for number in range(20, 45):
        estimate = tracker.process(even(None, noise), number * STEP)
    assert estimate.status.value == "LOST"
    assert estimate.presence < 0.1
    for number in range(45, 70):
        estimate = tracker.process(even((230, 90), noise), number * STEP)
    assert estimate.status.value == "TRACKING"
    assert overlap(estimate.box, (208, 76, 253, 105)) > 0.7


def test_a_target_out_of_view_is_not_learnt_anew_when_colour_goes(draw):
    tracker, _ = started(draw)
    for number in range(2, 50):
        image, _ = draw(centre=(160, 120) if number < 10 else None, seed=number)
        if number >= 25:
            image = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
        estimate = tracker.process(image, number * STEP)
        assert number < 15 or estimate.status.value == "LOST"


def test_a_target_of_little_colour_stays_learnt_in_colour():
    tracker = TargetTracker(TargetParameters(seed=1))
    tracker.initialise(TargetStart.from_box(138, 106, 183, 135))
    for number in range(1, 25):
        image = even((160, 120))
        if number > 5:  # Hidden but for a strip, of less than a percent of the pixels.
            image[:, 142:] = 110
        estimate = tracker.process(image, number * STEP)
    assert estimate.presence < 0.1
    estimate = [tracker.process(even((160, 120)), n * STEP) for n in range(25, 32)][-1]
    assert estimate.status.value == "TRACKING"


def bar(length, width, seed):
    """A red bar across the middle of the picture."""
    picture = np.full((240, 320, 3), (90.0, 80.0, 40.0))
    rows, columns = (slice(c - s // 2, c + s // 2) for c, s in ((120, width), (160, length)))
    picture[rows, columns] = (30, 30, 200)
    noise = np.random.default_rng(seed).normal(0.0, 6.0, picture.shape)
    return np.clip(picture + noise, 0, 255).astype(np.uint8)


def followed_bar(length, width):
    """The estimates of a bar that is marked by its box and stands still."""
    tracker = TargetTracker(TargetParameters(seed=1))
    box = (160 - length // 2, 120 - width // 2, 160 + length // 2, 120 + width // 2)
    tracker.initialise(TargetStart.from_box(*box))
    return [tracker.process(bar(length, width, n), n * STEP) for n in range(1, 26)], box


def test_a_long_target_is_followed_in_its_whole_length():
    estimates, box = followed_bar(160, 14)
    assert min(overlap(estimate.box, box) for estimate in estimates) > 0.9
    assert all(estimate.is_whole for estimate in estimates)


def test_no_size_is_told_of_a_target_that_is_like_a_line():
    estimates, box = followed_bar(240, 10)
    assert overlap(estimates[0].box, box) > 0.95
    assert all(estimate.status.value == "TRACKING" for estimate in estimates)
    assert not any(estimate.is_whole for estimate in estimates)


def test_large_frames_are_reduced_and_told_in_their_own_pixels(draw):
    tracker, estimate = started(draw, centre=(320, 240), axes=(44, 28), size=(640, 480))
    mask = draw(centre=(320, 240), axes=(44, 28), size=(640, 480))[1]
    assert overlap(estimate.box, bounding_box(mask)) > 0.85
    assert np.abs(tracker.particles.states[:, :2]).max() < 20.0


def test_turns_of_the_camera_are_followed(draw):
    tracker, _ = started(draw, centre=(60, 120))
    shift = np.eye(3)
    shift[0, 2] = 150.0
    estimate = tracker.process(draw(centre=(210, 120), seed=2)[0], 2 * STEP, CameraMotion(shift))
    assert estimate.status.value == "TRACKING"
    assert estimate.state[0] == pytest.approx(50.5, abs=3.0)


def turned_right(degrees):
    """What a turn of a camera of 60 deg across does to its picture."""
    angle = math.radians(degrees)
    cosine, sine = math.cos(angle), math.sin(angle)
    rotation = np.array([[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]])
    matrix = np.diag([277.0, 277.0, 1.0])
    mapping = matrix @ rotation @ np.linalg.inv(matrix)
    return CameraMotion(mapping / mapping[2, 2])


@pytest.mark.parametrize("degrees", [80.0, 89.9, -88.0, 120.0])
def test_a_turn_away_from_the_target_is_taken_as_not_known(draw, degrees):
    tracker, _ = started(draw)
    twin = tracker.copy()
    image, _ = draw(centre=(163, 120), seed=2)
    estimate = tracker.process(image, 2 * STEP, turned_right(degrees))
    np.testing.assert_array_equal(estimate.state, twin.process(image, 2 * STEP).state)


def test_what_does_not_stand_out_is_said_and_not_claimed(draw):
    tracker = TargetTracker()
    tracker.initialise(TargetStart.from_box(100, 80, 150, 120))
    estimate = tracker.process(draw(centre=None)[0], STEP)
    assert estimate.status.value == "INITIALISING"
    assert "stand out" in estimate.event
    assert estimate.box is None


def test_a_mark_that_does_not_stand_out_costs_no_target_that_is_followed(draw):
    tracker, _ = started(draw)
    twin = tracker.copy()
    tracker.initialise(TargetStart.from_box(20, 20, 60, 50))
    image, _ = draw(centre=(163, 120), seed=2)
    estimate, expected = (each.process(image, 2 * STEP) for each in (tracker, twin))
    assert "stand out" in estimate.event
    assert estimate.status.value == "TRACKING"
    np.testing.assert_array_equal(estimate.state, expected.state)


def test_a_mark_that_does_not_stand_out_does_not_hide_that_the_one_before_is_forgotten(draw):
    tracker, _ = started(draw)
    tracker.initialise(TargetStart.from_box(20, 20, 60, 50))
    event = tracker.process(draw(size=(400, 300), seed=2)[0], 2 * STEP).event
    assert "size changed" in event and "mark it again" in event and "stand out" in event


def test_a_mark_that_does_not_stand_out_does_not_hide_a_gap(draw):
    tracker, _ = started(draw)
    tracker.initialise(TargetStart.from_box(20, 20, 60, 50))
    event = tracker.process(draw(seed=2)[0], 20_000_000_000).event
    assert "no frame for" in event and "stand out" in event


def test_a_mark_waits_for_a_frame_that_can_be_used(draw):
    tracker, _ = started(draw)
    image, _ = draw(seed=2)
    other, mask = draw(centre=(230, 120))
    image[mask] = other[mask]
    tracker.initialise(TargetStart.from_box(*bounding_box(mask)))
    with pytest.raises(FrameError, match="stamp"):
        tracker.process(image, STEP)
    assert tracker.process(image, 2 * STEP).state[0] == pytest.approx(70.5, abs=3.0)


def test_without_a_mark_nothing_is_claimed(draw):
    estimate = TargetTracker().process(draw()[0], STEP)
    assert estimate.status.value == "INITIALISING"
    assert estimate.box is None


@pytest.mark.parametrize("box", [(400, 10, 450, 60), (-90, -60, -50, -20), (-5, -5, 400, 300)])
def test_marks_that_cannot_be_are_refused(draw, box):
    tracker = TargetTracker()
    tracker.initialise(TargetStart.from_box(*box))
    with pytest.raises(FrameError, match="marked target"):
        tracker.process(draw()[0], STEP)
    assert tracker.process(draw()[0], STEP).status.value == "INITIALISING"
    with pytest.raises(FrameError, match="marked target"):
        tracker.initialise(TargetStart.from_box(*box))


def test_frames_that_cannot_be_used_are_refused_and_change_nothing(draw):
    tracker, before = started(draw)
    for image in (
        np.zeros((240, 320)),
        np.zeros((240, 320, 4), np.uint8),
        np.zeros((4, 4), np.uint8),
    ):
        with pytest.raises(FrameError):
            tracker.process(image, 2 * STEP)
    with pytest.raises(FrameError, match="stamp"):
        tracker.process(draw()[0], STEP)
    after = tracker.process(draw(seed=2)[0], 2 * STEP)
    assert after.state[:2] == pytest.approx(before.state[:2], abs=3.0)


def test_frames_of_another_size_begin_anew(draw):
    tracker, _ = started(draw)
    estimate = tracker.process(draw(size=(400, 300))[0], 2 * STEP)
    assert estimate.status.value == "INITIALISING"
    assert "size changed" in estimate.event and "mark it again" in estimate.event


@pytest.mark.parametrize("pause", [6.0, -2.0], ids=["a gap", "time goes back"])
def test_a_marked_target_is_looked_for_after(draw, pause):
    tracker, before = started(draw)
    again = 10_000_000_000 + round(pause * 1e9)
    if pause < 0.0:
        tracker.process(draw(seed=2)[0], 10_000_000_000)
    estimate = tracker.process(draw(seed=3)[0], again)
    assert estimate.event
    for number in range(1, 12):
        estimate = tracker.process(draw(seed=number)[0], again + number * STEP)
    assert estimate.status.value == "TRACKING"
    assert estimate.state[:2] == pytest.approx(before.state[:2], abs=4.0)


@pytest.mark.parametrize("pause", [6.0, -0.3], ids=["a gap", "time goes back"])
def test_no_pause_counts_for_the_time_for_which_a_lost_target_must_be_seen(draw, pause):
    tracker, _ = started(draw)
    tracker.configure(tracker.parameters.replaced({"confirmation_time": 1.0}))
    for number in range(2, 14):
        lost = tracker.process(draw(centre=None, seed=number)[0], number * STEP)
    assert lost.status.value == "LOST"
    again = 13 * STEP + round(pause * 1e9)
    for number in range(20):
        estimate = tracker.process(draw(seed=number)[0], again + number * STEP)
        assert estimate.status.value == "LOST"
    for number in range(20, 40):
        estimate = tracker.process(draw(seed=number)[0], again + number * STEP)
    assert estimate.status.value == "TRACKING"


@pytest.mark.parametrize("change", [{"working_width": 200}, {"filter": "blobs"}])
def test_a_change_that_forgets_the_marked_target_says_so_once(draw, change):
    tracker, _ = started(draw)
    tracker.configure(tracker.parameters.replaced(change))
    events = [tracker.process(draw(seed=n)[0], n * STEP).event for n in (2, 3)]
    assert "mark it again" in events[0] and events[1] == ""


@pytest.mark.parametrize("second", [{"filter": "blobs"}, {"working_width": 320}])
def test_a_second_change_does_not_hide_that_the_first_forgot_the_marked_target(draw, second):
    tracker, _ = started(draw)
    for change in ({"working_width": 200}, second):
        tracker.configure(tracker.parameters.replaced(change))
    assert "mark it again" in tracker.process(draw(seed=2)[0], 2 * STEP).event


@pytest.mark.parametrize("change", [{"working_width": 200}, {}], ids=["width", "image size"])
def test_what_takes_the_place_of_a_forgotten_target_need_not_be_marked_again(draw, change):
    tracker, _ = started(draw)
    tracker.configure(tracker.parameters.replaced(change))
    image, mask = draw(size=(320, 240) if change else (400, 300), seed=2)
    tracker.initialise(TargetStart.from_box(*bounding_box(mask)))
    estimate = tracker.process(image, 2 * STEP)
    assert tracker.has_begun and estimate.status.value == "TRACKING"
    assert "mark it again" not in estimate.event
    assert ("size changed" in estimate.event) is not bool(change)
    assert tracker.process(draw(seed=3, size=image.shape[1::-1])[0], 3 * STEP).event == ""


def test_reset_forgets_and_repeats(draw):
    tracker, first = started(draw)
    tracker.reset()
    assert tracker.particles is None
    image, mask = draw()
    tracker.initialise(TargetStart.from_box(*bounding_box(mask)))
    np.testing.assert_array_equal(tracker.process(image, STEP).covariance, first.covariance)


def test_parameters_change_on_the_way(draw):
    tracker, _ = started(draw)
    tracker.configure(TargetParameters(particle_count=77))
    tracker.process(draw(seed=2)[0], 2 * STEP)
    assert tracker.particles.count == 77


@pytest.mark.parametrize("change", [{"memory_time": 0.04}, {"ratio_limit": 0.3}])
def test_what_was_set_at_the_start_may_be_changed_on_the_way(draw, change):
    tracker, _ = started(draw)
    twin = tracker.copy()
    twin.configure(tracker.parameters.replaced(change))
    for number in range(2, 12):
        image, _ = draw(centre=None, seed=number)
        ours, other = (each.process(image, number * STEP) for each in (tracker, twin))
    assert [*ours.state, ours.area] != [*other.state, other.area]


def test_a_target_that_none_of_the_particles_can_have_kept_is_no_error(draw):
    rates = {"disappearance_rate": 100.0, "leaving_rate": 100.0, "maximum_gap": 20.0}
    tracker = TargetTracker(TargetParameters(**rates))
    tracker.initialise(TargetStart.from_box(*bounding_box(draw()[1])))
    tracker.process(draw()[0], STEP)
    for number in range(3):
        estimate = tracker.process(draw(seed=number)[0], 10_000_000_000 + number * STEP)
        assert np.isfinite(estimate.state).all()
        assert np.isfinite(estimate.presence)


def test_the_angle_of_an_estimate_has_no_whole_turns(draw):
    tracker, before = started(draw)
    turn = math.radians(100.0)
    roll = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    homography = np.eye(3)
    homography[:2, :2] = roll
    place = before.state[:2]
    for number in range(2, 7):
        place = roll @ place
        centre = (round(place[0] + 159.5), round(119.5 - place[1]))
        image, _ = draw(centre=centre, seed=number, tilt=100 * (number - 1))
        estimate = tracker.process(image, number * STEP, CameraMotion(homography))
        expected = math.remainder((number - 1) * turn, 2.0 * math.pi)
        assert estimate.state[3] == pytest.approx(expected, abs=0.3)


@pytest.mark.parametrize("name", ["poses", "blobs"])
def test_frames_of_which_no_row_would_be_left_are_refused(name):
    tracker = TargetTracker(TargetParameters(filter=name))
    picture = np.full((16, 4096, 3), (90, 80, 40), np.uint8)
    picture[:, 1000:1400] = 0
    tracker.initialise(TargetStart.from_box(1000, 2, 1400, 14))
    with pytest.raises(FrameError, match=r"4096x16 px.* working_width"):
        tracker.process(picture, STEP)


@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_a_handful_of_particles_is_no_error(draw, count):
    tracker = TargetTracker(TargetParameters(particle_count=count))
    _, mask = draw()
    tracker.initialise(TargetStart.from_box(*bounding_box(mask)))
    for number in range(1, 4):
        estimate = tracker.process(draw(seed=number)[0], number * STEP)
    assert np.isfinite(estimate.state).all()
    assert tracker.particles.count == count


def test_the_contour_is_that_of_the_largest_area_and_not_of_the_most_corners():
    mask = np.zeros((60, 80), bool)
    mask[5:45, 10:50] = True
    mask[50:56, 60:72:2] = mask[52, 60:72] = True
    corners = Outline(mask, (100, 20, 180, 80), 1.0).corners(zoom=2.0)
    assert corners.min(axis=0) == pytest.approx([2 * 110.5, 2 * 25.5])
    assert corners.max(axis=0) == pytest.approx([2 * 149.5, 2 * 64.5])


def test_what_a_detector_proposed_is_not_looked_for_for_ever():
    rng = np.random.default_rng(0)
    bottom = np.clip(rng.normal((120, 100, 50), 6, (240, 320, 3)), 0, 255).astype(np.uint8)

    def picture(centre, colour):
        shown = bottom.copy()
        if centre is not None:
            cv2.ellipse(shown, centre, (22, 16), 0, 0, 360, colour, -1)
        return shown

    tracker = TargetTracker(TargetParameters(seed=1, detector="contours", memory_time=0.4))
    statuses = []
    for number in range(120):
        shown = picture((100 + number, 120), (40, 40, 190)) if number < 25 else picture(None, ())
        if number >= 40:
            shown = picture((220, 80), (20, 200, 220))
        statuses.append(tracker.process(shown, (number + 1) * 40_000_000).status)
    assert statuses[24] is TrackingStatus.TRACKING
    assert statuses[39] is TrackingStatus.LOST
    assert statuses[-1] is TrackingStatus.TRACKING


def dim(image, light=1.0):
    """Return a picture as a camera of 10 bits gives it that are sent in 16."""
    return (light * image / 64.0).astype(np.float32)


@pytest.mark.parametrize("light", [1.0, 4.0], ids=["even light", "light that grows"])
def test_a_target_within_a_few_levels_of_a_deep_camera_is_followed(draw, light):
    tracker = TargetTracker(TargetParameters(seed=1))
    image, mask = draw()
    tracker.initialise(TargetStart.from_box(*bounding_box(mask)))
    tracker.process(dim(image), STEP)
    for number in range(2, 12):
        image, mask = draw(centre=(160 + 4 * number, 120), seed=number)
        estimate = tracker.process(dim(image, light ** (number / 11)), number * STEP)
    assert estimate.status is TrackingStatus.TRACKING
    assert overlap(estimate.box, bounding_box(mask)) > 0.7


def test_a_deep_camera_that_uses_its_levels_is_measured_as_8_bits(draw):
    deep, plain = started(draw)[0], started(draw)[0]
    image = draw(centre=(166, 120), seed=2)[0]
    assert np.array_equal(
        deep.process(image.astype(np.float32), 2 * STEP).state, plain.process(image, 2 * STEP).state
    )


def test_levels_that_are_no_numbers_are_refused(draw):
    picture = dim(draw()[0])
    picture[3, 3] = np.nan
    with pytest.raises(FrameError, match="NaN"):
        TargetTracker().process(picture, STEP)


def velocities(draw, times):
    """The published v_x of a target that moves at 40 px/s, in all frames but the first six."""
    tracker = TargetTracker(TargetParameters())
    published = []
    for number, time in enumerate(times):
        column = 60 + 40 * time
        picture, _ = draw(centre=(round(column), 120), seed=number)
        if number == 0:
            tracker.initialise(TargetStart.from_box(38, 106, 83, 135))
        estimate = tracker.process(picture, 1_000_000_000 + round(time * 1e9))
        assert estimate.is_claimed
        published.append(estimate.state[4])
    return np.array(published[6:])


@pytest.mark.parametrize(("rate", "seconds"), [(5, 4.0), (10, 3.0), (25, 2.0)])
def test_a_steady_movement_is_published_at_every_frame_rate(draw, rate, seconds):
    published = velocities(draw, np.arange(int(rate * seconds)) / rate)
    assert published.mean() == pytest.approx(40.0, rel=0.2)


def test_frames_that_follow_one_another_closely_make_no_absurd_velocity(draw):
    beginnings = np.arange(20) * 0.1
    times = np.sort(np.concatenate((beginnings, beginnings + 1e-3)))
    assert velocities(draw, times) == pytest.approx(40.0, abs=30.0)
