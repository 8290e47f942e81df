from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cable_tracker.cable.model.state import STATE_SIZE, CableState
from cable_tracker.errors import RecordingError
from cable_tracker.sequences.tables.estimates import (
    HEADER,
    EstimateRow,
    format_stamp,
    parse_stamp,
    read_estimates,
    write_estimates,
)

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


def test_the_file_looks_as_the_design_says(tmp_path):
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


def test_a_table_of_an_older_version_is_refused_with_the_way_out(tmp_path):
    (tmp_path / "e.csv").write_text(
        "frame,stamp,status,d,alpha,w,beta,v_d,v_alpha,"
        "sigma_d,sigma_alpha,sigma_w,sigma_beta,n_eff,ms\n"
    )
    with pytest.raises(RecordingError, match="older versions lack some: track the recording again"):
        read_estimates(tmp_path / "e.csv")


def test_equal_rows_give_equal_bytes(tmp_path):
    for name in ("a", "b"):
        write_estimates(tmp_path / name, [ROW, replace(ROW, frame=8)])
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


@given(st.integers(-(10**20), 10**20))
def test_stamps_lose_nothing(stamp):
    assert parse_stamp(format_stamp(stamp)) == stamp


@pytest.mark.parametrize(
    ("text", "stamp"),
    [("0.000000001", 1), ("-0.5", -500_000_000), ("3", 3_000_000_000), ("1.25", 1_250_000_000)],
)
def test_stamps_are_seconds(text, stamp):
    assert parse_stamp(text) == stamp


@pytest.mark.parametrize("value", [math.pi, 5e-324, 1.7976931348623157e308, 0.1 + 0.2])
def test_numbers_are_exact_to_the_last_bit(tmp_path, value):
    row = replace(ROW, n_eff=value)
    write_estimates(tmp_path / "e.csv", [row])
    assert read_estimates(tmp_path / "e.csv")[0].n_eff == value


def test_a_missing_table_is_refused(tmp_path):
    with pytest.raises(RecordingError, match=r"e\.csv"):
        read_estimates(tmp_path / "e.csv")


@pytest.mark.parametrize("content", [b"", b"a,b\n", b"\xff\xfe\x00"])
def test_what_is_no_table_is_refused(tmp_path, content):
    (tmp_path / "e.csv").write_bytes(content)
    with pytest.raises(RecordingError, match=r"e\.csv"):
        read_estimates(tmp_path / "e.csv")


@pytest.mark.parametrize("line", ["x", "1,2", "1,y,LOST" + "," * 12, "1,2.0,LOST,a" + "," * 11])
def test_a_bad_line_is_named(tmp_path, line):
    (tmp_path / "e.csv").write_text(",".join(HEADER) + "\n" + line + "\n")
    with pytest.raises(RecordingError, match="line 2"):
        read_estimates(tmp_path / "e.csv")


@with_files
@given(st.text(alphabet='0123456789.,-en"\n\r\0 ', max_size=100))
def test_any_table_is_read_or_refused(tmp_path, text):
    (tmp_path / "e.csv").write_bytes((",".join(HEADER) + "\n" + text).encode())
    try:
        read_estimates(tmp_path / "e.csv")
    except RecordingError as error:
        assert "e.csv" in str(error)
