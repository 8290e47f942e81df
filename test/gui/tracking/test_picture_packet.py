import math

import cv2
import numpy as np
import pytest

pytest.importorskip("nicegui", reason="NICEGUI IS NOT INSTALLED: the pages are not tested")

from cable_tracker.cable.model.estimate import Hypothesis
from cable_tracker.cable.model.state import CableState
from cable_tracker.gui.session.session import CableSnapshot, TargetSnapshot
from cable_tracker.gui.tracking.picture_feed import HistoryColumn, TrackingHistory
from cable_tracker.gui.tracking.picture_packet import (
    LARGEST_CLOUD,
    LARGEST_HEIGHT,
    LARGEST_WIDTH,
    MOST_OPAQUE,
    heaviest,
    layers_of,
    make_packet,
    particle_lines,
    target_layers,
    target_particles,
)
from cable_tracker.offline.target_table import TargetClaim, TargetRow
from cable_tracker.sequences.tables.estimates import EstimateRow

from ..conftest import unpack

CABLE = CableState(10.0, math.radians(5.0), 20.0, 0.0, 3.0)
GREY = np.full((48, 64), 90, np.uint8)
SECOND = 1_000_000_000


def snapshot(number=1, image=GREY, cloud=None, hypotheses=(), truth=None, **row):
    row = {"stamp": SECOND, "status": "TRACKING"} | row
    return CableSnapshot(
        number=number,
        frame=number,
        image=image,
        row=EstimateRow(number, **row),
        rate_sigma=(0.1,) * 4,
        cloud=cloud,
        hypotheses=hypotheses,
        truth=truth,
    )


def tracked(**given):
    rng = np.random.default_rng(1)
    cloud = np.column_stack((rng.normal(CABLE.to_array(), 1.0, (30, 8)), rng.random(30)))
    return snapshot(state=CABLE, sigma=(0.1,) * 4, cloud=cloud, **given)


def packed(snapshot, **given):
    given = {"history": np.empty((0, 11)), "is_whole": True, "fps": None} | given
    return unpack(make_packet(snapshot, given.pop("history"), **given))


CLAIM = TargetClaim(
    state=(4.0, 6.0, 1.5, math.radians(10.0), 30.0, 0.0),
    sigma=(1.0, 2.0, 0.1, 0.2),
    box=(10.0, 5.0, 40.0, 35.0),
    area=400.0,
)


def followed(claim=CLAIM, **given):
    """Return a snapshot of a target, on a coloured picture."""
    rng = np.random.default_rng(1)
    given = {
        "outline": np.array([[10.0, 5.0], [40.0, 5.0], [25.0, 35.0]]),
        "cloud": np.column_stack((rng.normal(0.0, 3.0, (30, 6)), rng.random(30))),
        "image": np.full((48, 64, 3), (90, 80, 200), np.uint8),
    } | given
    return TargetSnapshot(1, 1, row=TargetRow(1, SECOND, "TRACKING", claim), **given)


def layer(layers, name):
    return next(layer for layer in layers if layer["name"] == name)


def test_a_packet_brings_picture_particles_and_numbers_in_degrees():
    description, sections = packed(tracked(presence=0.9, n_eff=12.0))
    assert description["state"][:2] == pytest.approx([10.0, 5.0])
    assert description["sigma"][1] == pytest.approx(math.degrees(0.1))
    assert len(description["sigma"]) == 8
    assert sections["cloud"].shape == (30, 9)
    assert sections["cloud"][:, -1].max() == 1.0
    picture = cv2.imdecode(np.frombuffer(sections["picture"], np.uint8), cv2.IMREAD_GRAYSCALE)
    assert picture.shape == GREY.shape


def test_what_is_not_known_is_left_empty():
    description, sections = packed(snapshot(status="LOST", evidence=math.nan))
    assert description["state"] is None
    assert ["evidence", None, 2, "evidence"] in description["facts"]
    assert description["particle_count"] == 0
    assert len(sections["particles"]) == 0


def test_a_wide_picture_is_reduced_and_the_numbers_stay_those_of_the_frame():
    description, sections = packed(snapshot(image=np.zeros((100, 2 * LARGEST_WIDTH), np.uint8)))
    picture = cv2.imdecode(np.frombuffer(sections["picture"], np.uint8), cv2.IMREAD_GRAYSCALE)
    assert picture.shape[1] == LARGEST_WIDTH
    assert description["size"] == [2 * LARGEST_WIDTH, 100]


def test_a_picture_taller_than_any_jpeg_is_reduced():
    description, sections = packed(snapshot(image=np.zeros((65_501, 8), np.uint8)))
    picture = cv2.imdecode(np.frombuffer(sections["picture"], np.uint8), cv2.IMREAD_GRAYSCALE)
    assert picture.shape == (LARGEST_HEIGHT, 1)
    assert description["size"] == [8, 65_501]


def test_lines_lie_where_the_cable_is():
    upright = CableState(10.0, 0.0, 20.0)
    points = layer(layers_of(snapshot(state=upright)), "centreline")["points"]
    assert points[0] == points[2] == pytest.approx(32.0 + 10.0)
    left, _, _, _, right = layer(layers_of(snapshot(state=upright)), "estimate")["points"][:5]
    assert (left, right) == pytest.approx((32.0, 52.0))


def test_the_band_is_as_wide_as_two_sigma_in_the_middle():
    band = layer(layers_of(snapshot(state=CableState(0.0, 0.0, 20.0), sigma=(3.0,) * 4)), "band")
    x = np.array(band["points"]).reshape(-1, 2)[:, 0]
    assert np.ptp(x[[10, 31]]) == pytest.approx(12.0)


def test_without_a_number_for_sigma_there_is_no_band():
    unknown = layers_of(snapshot(state=CABLE, sigma=(math.nan,) * 4))
    assert "band" not in [layer["name"] for layer in unknown]


def test_only_what_is_known_is_drawn():
    names = [layer["name"] for layer in layers_of(snapshot(truth=CABLE))]
    assert names == ["hypotheses", "truth"]


def test_other_hypotheses_are_drawn_if_likely():
    others = (Hypothesis(0.7, CABLE), Hypothesis(0.29, CABLE), Hypothesis(0.01, CABLE))
    drawn = layer(layers_of(snapshot(state=CABLE, hypotheses=others)), "hypotheses")
    assert len(drawn["points"]) == 4


def test_particles_run_as_the_centreline_does():
    cloud = np.append(CableState(10.0, 0.0, 20.0).to_array(), 1.0)[None]
    x1, y1, x2, y2, opacity = particle_lines(cloud, (64, 48))[0]
    assert (x1, x2) == pytest.approx((42.0, 42.0))
    assert min(y1, y2) < 0.0
    assert max(y1, y2) > 48.0
    assert opacity == MOST_OPAQUE


def test_the_heaviest_particles_are_sent_and_those_that_are_no_numbers_are_not():
    cloud = np.zeros((LARGEST_CLOUD + 50, 9))
    cloud[:, -1] = np.arange(len(cloud))
    cloud[-1, 2] = math.nan
    kept = heaviest(cloud)
    assert len(kept) == LARGEST_CLOUD
    assert kept[-1, -1] == 1.0


def history_of(stamps):
    history = TrackingHistory()
    for number, stamp in enumerate(stamps):
        history.add(tracked(number=number, stamp=int(stamp * SECOND)))
    return history


def times(history, now, *, is_whole):
    return history.table(now * SECOND, is_whole=is_whole)[:, HistoryColumn.TIME].tolist()


def test_history_is_that_of_the_last_half_minute():
    assert times(history_of(range(100)), 99, is_whole=True) == list(range(-30, 1))


def test_with_a_picture_goes_the_history_of_two_seconds():
    assert times(history_of(range(10)), 9, is_whole=False) == [-2.0, -1.0, 0.0]


def test_going_back_takes_away_what_came_after():
    assert times(history_of([0, 1, 2, 3, 1]), 3, is_whole=True) == [-3.0, -2.0]


def test_where_no_cable_is_claimed_the_history_has_no_number():
    history = TrackingHistory()
    history.add(snapshot(status="WHATEVER"))
    row = history.table(SECOND, is_whole=True)[0]
    assert math.isnan(row[HistoryColumn.FIRST])
    assert row[HistoryColumn.STATUS] == 5


def test_a_target_is_packed_in_colour_with_its_numbers():
    description, sections = packed(followed())
    assert description["state"] == pytest.approx([4.0, 6.0, 1.5, 10.0, 30.0, 0.0])
    assert description["sigma"] == pytest.approx([1.0, 2.0, 0.1, math.degrees(0.2)])
    assert ["size px", 20.0, 1, "size"] in description["facts"]
    assert sections["cloud"].shape == (30, 7)
    picture = cv2.imdecode(np.frombuffer(sections["picture"], np.uint8), cv2.IMREAD_COLOR)
    assert np.abs(picture.mean(axis=(0, 1)) - (90, 80, 200)).max() < 4.0


def test_box_and_contour_of_a_target_are_closed_lines_in_pixels_of_the_picture():
    layers = target_layers(followed(truth=(1.0, 2.0, 3.0, 4.0)))
    sides = np.array(layer(layers, "box")["points"]).reshape(-1, 2, 2)
    assert sides.tolist() == [
        [[10, 5], [40, 5]], [[40, 5], [40, 35]], [[40, 35], [10, 35]], [[10, 35], [10, 5]],
    ]  # fmt: skip
    assert len(layer(layers, "contour")["points"]) == 12
    assert layer(layers, "truth")["dash"]
    band = np.array(layer(layers, "band")["points"]).reshape(-1, 2)
    assert band.mean(axis=0) == pytest.approx((32 + 4, 24 - 6), abs=0.3)


def test_a_target_that_is_not_claimed_leaves_the_picture_bare():
    lost = followed(None, outline=np.empty((0, 2)))
    assert target_layers(lost) == []
    assert packed(lost)[0]["state"] is None


def test_a_target_whose_place_is_no_number_is_not_drawn():
    claim = TargetClaim((math.nan,) * 6, CLAIM.sigma, (math.nan,) * 4, math.nan)
    nowhere = followed(claim, outline=np.full((4, 2), math.nan))
    assert packed(nowhere)[0]["state"] == [None] * 6
    assert [each["points"] for each in target_layers(nowhere)] == [[], []]


def test_particles_of_a_target_are_crosses_about_their_places():
    cloud = np.array([[10.0, -4.0, 1.0, 0.0, 0.0, 0.0, 1.0]])
    across, upright = target_particles(cloud, (64, 48))
    assert (across[:4].reshape(2, 2).mean(axis=0) == (42.0, 28.0)).all()
    assert (upright[:4].reshape(2, 2).mean(axis=0) == (42.0, 28.0)).all()


def test_the_history_of_a_target_is_of_its_centre():
    history = TrackingHistory()
    history.add(followed())
    (row,) = history.table(SECOND, is_whole=True)
    assert row[[HistoryColumn.FIRST, HistoryColumn.SECOND]].tolist() == [4.0, 6.0]
    assert row[[HistoryColumn.FIRST_SIGMA, HistoryColumn.SECOND_SIGMA]].tolist() == [1.0, 2.0]
