from __future__ import annotations

import math
from dataclasses import replace
from decimal import Decimal

import pytest
from estimate_reader import read_estimates
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cable_tracker.cable.model.state import STATE_SIZE, CableState
from cable_tracker.sequences.tables.estimates import (
    EstimateRow,
    format_stamp,
    write_estimates,
)
from cable_tracker.stamps import NANOSECONDS

finite = st.floats(allow_nan=False, allow_infinity=False)
states = st.builds(CableState, *[finite] * STATE_SIZE)
claimed = st.builds(
    EstimateRow,
    frame=st.integers(0, 10**9),
    stamp=st.integers(-(10**19), 10**19),
    status=st.just("TRACKING"),
    state=states,
    sigma=st.tuples(finite, finite, finite, finite),
    n_eff=finite,
    presence=st.none() | finite,
    evidence=finite,
    hypotheses=st.integers(0, 100),
    ms=st.none() | st.integers(0, 10**6).map(lambda micro: micro / 1000),
)
unclaimed = st.builds(
    EstimateRow,
    frame=st.integers(0, 10**9),
    stamp=st.integers(0, 10**19),
    status=st.sampled_from(["LOST", "INITIALISING", "REFUSED"]),
    n_eff=st.none() | finite,
    presence=st.none() | finite,
    evidence=st.none() | finite,
    hypotheses=st.none() | st.integers(0, 100),
)
with_files = settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow]
)

ROW = EstimateRow(
    frame=7,
    stamp=1_700_000_000_040_000_000,
    status="TRACKING",
    state=CableState(1.5, -0.25, 40.0, 0.125, 2.0, -3.0, 4.0, 0.5),
    sigma=(0.5, 0.25, 1.0, 0.125),
    n_eff=120.5,
    presence=0.98,
    evidence=2.25,
    hypotheses=2,
    ms=16.5,
)


@with_files
@given(st.lists(claimed | unclaimed, max_size=5))
def test_rows_are_read_as_they_were_written(tmp_path, rows):
    write_estimates(tmp_path / "e.csv", rows)
    assert read_estimates(tmp_path / "e.csv") == rows


def test_the_file_has_the_designed_format(tmp_path):
    lost = EstimateRow(8, 40_000_000, "LOST", n_eff=3.0, evidence=0.5, hypotheses=0)
    write_estimates(tmp_path / "e.csv", [ROW, lost])
    assert (tmp_path / "e.csv").read_text().splitlines() == [
        "frame,stamp,status,d,alpha,w,beta,v_d,v_alpha,v_w,v_beta,"
        "sigma_d,sigma_alpha,sigma_w,sigma_beta,n_eff,presence,evidence,hypotheses,ms,"
        "offset,heading,sigma_offset,sigma_heading,no_metres,event",
        "7,1700000000.040000000,TRACKING,1.5,-0.25,40.0,0.125,2.0,-3.0,4.0,0.5,"
        "0.5,0.25,1.0,0.125,120.5,0.98,2.25,2,16.500,,,,,,",
        "8,0.040000000,LOST,,,,,,,,,,,,,3.0,,0.5,0,,,,,,,",
    ]


def test_equal_rows_give_equal_bytes(tmp_path):
    for name in ("a", "b"):
        write_estimates(tmp_path / name, [ROW, replace(ROW, frame=8)])
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


@given(st.integers(-(10**20), 10**20))
def test_stamps_lose_nothing(stamp):
    assert int(Decimal(format_stamp(stamp)) * NANOSECONDS) == stamp


@pytest.mark.parametrize(
    ("stamp", "text"),
    [
        (1, "0.000000001"),
        (-500_000_000, "-0.500000000"),
        (3_000_000_000, "3.000000000"),
        (1_250_000_000, "1.250000000"),
    ],
)
def test_stamps_are_seconds(stamp, text):
    assert format_stamp(stamp) == text


@pytest.mark.parametrize("value", [math.pi, 5e-324, 1.7976931348623157e308, 0.1 + 0.2])
def test_numbers_are_exact_to_the_last_bit(tmp_path, value):
    row = replace(ROW, n_eff=value)
    write_estimates(tmp_path / "e.csv", [row])
    assert read_estimates(tmp_path / "e.csv")[0].n_eff == value
