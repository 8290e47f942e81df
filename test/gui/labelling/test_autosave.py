import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from label_strategies import label_maps

from cable_tracker.errors import RecordingError
from cable_tracker.gui.labelling.autosave import read_autosave, write_autosave


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(label_maps)
def test_unsaved_labels_are_read_back_as_they_were(tmp_path, labels):
    path = tmp_path / "dive.txt.autosave"
    stamps = {frame: 40_000_000 * frame for frame in labels if frame % 2}
    write_autosave(path, labels, stamps)
    assert read_autosave(path) == (labels, stamps)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "line 1"),
        ("frame,d\n", "line 1"),
        ("frame,stamp,flag,d,alpha,w,beta\n1,,hand,1,2\n", "line 2"),
        ("frame,stamp,flag,d,alpha,w,beta\n1,,hand,1,0,nan,0\n", "line 2 .*not finite"),
        ("frame,stamp,flag,d,alpha,w,beta\n-1,,no_cable,,,,\n", "line 2 .*no frame -1"),
        ("frame,stamp,flag,d,alpha,w,beta\n1,,no_cable,,,,\nx,,hand,1,0,3,0\n", "line 3"),
    ],
)
def test_a_damaged_file_is_told_by_line(tmp_path, text, reason):
    path = tmp_path / "dive.txt.autosave"
    path.write_text(text)
    with pytest.raises(RecordingError, match=reason):
        read_autosave(path)


pieces = st.sampled_from(
    [
        "frame,stamp,flag,d,alpha,w,beta\n",
        "1,2,hand,3,0,5,0\n",
        "no_cable",
        ",",
        "\n",
        '"',
        "9" * 5000,
    ]
)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(st.lists(pieces | st.text(max_size=5), max_size=12))
def test_whatever_a_file_holds_only_one_error_comes_of_it(tmp_path, parts):
    path = tmp_path / "dive.txt.autosave"
    path.write_bytes("".join(parts).encode("utf-8", "surrogatepass"))
    try:
        read_autosave(path)
    except RecordingError as error:
        assert "\n" not in str(error)
