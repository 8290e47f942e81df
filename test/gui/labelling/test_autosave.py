from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from label_strategies import label_maps

from cable_tracker.errors import RecordingError
from cable_tracker.gui.labelling.autosave import read_autosave, write_autosave
from cable_tracker.gui.labelling.labels import WITHOUT_CABLE, FrameLabel, stamps_of
from cable_tracker.sequences.labels.frame_names import NumberedNames, PictureNames

NAMES = NumberedNames(Path("a.avi"))
HEAD = "frame,stamp,flag,d,alpha,w,beta,file\n"
PICTURES = PictureNames(Path("dive"), [f"{number:03d}.png" for number in range(30)])


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(label_maps, st.sampled_from([NAMES, PICTURES]))
def test_unsaved_labels_are_read_back_as_they_were(tmp_path, labels, names):
    path = tmp_path / "dive.txt.autosave"
    labels = {
        frame: replace(label, stamp=40_000_000 * frame if frame % 2 else None)
        for frame, label in labels.items()
    }
    write_autosave(path, labels, names)
    read = read_autosave(path, names)
    assert read == labels
    assert stamps_of(read) == stamps_of(labels)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "line 1"),
        ("frame,d\n", "line 1"),
        (f"{HEAD}1,,hand,1,2\n", "line 2"),
        (
            "frame,stamp,flag,d,alpha,w,beta,file\n1,,hand,1,0,nan,0,a.avi:1\n",
            "line 2 .*not finite",
        ),
        (f"{HEAD}1,,no_cable,,,,,b.png\n", "not of this recording"),
        (
            "frame,stamp,flag,d,alpha,w,beta,file\n1,,no_cable,,,,,a.avi:1\n2,x,hand,1,0,3,0,a.avi:2\n",
            "line 3",
        ),
    ],
)
def test_a_damaged_file_is_told_by_line(tmp_path, text, reason):
    path = tmp_path / "dive.txt.autosave"
    path.write_text(text)
    with pytest.raises(RecordingError, match=reason):
        read_autosave(path, NAMES)


def test_labels_stay_with_their_pictures_when_some_came_or_went(tmp_path):
    path = tmp_path / "dive.txt.autosave"
    labels = {2: WITHOUT_CABLE, 3: WITHOUT_CABLE, 4: FrameLabel(None, stamp=70)}
    write_autosave(path, labels, PICTURES)
    changed = PictureNames(Path("dive"), ["000a.png", "001.png", "003.png", "004.png"])
    read = read_autosave(path, changed)
    assert read == {2: WITHOUT_CABLE, 3: WITHOUT_CABLE}
    assert stamps_of(read) == {3: 70}


pieces = st.sampled_from(
    [
        HEAD,
        "1,2,hand,3,0,5,0,a.avi:1\n",
        "no_cable",
        ",",
        "\n",
        '"',
        "9" * 5000,
    ]
)


@settings(
    max_examples=25,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(st.lists(pieces | st.text(max_size=5), max_size=12))
def test_whatever_a_file_holds_only_one_error_comes_of_it(tmp_path, parts):
    path = tmp_path / "dive.txt.autosave"
    path.write_bytes("".join(parts).encode("utf-8", "surrogatepass"))
    try:
        read_autosave(path, NAMES)
    except RecordingError as error:
        assert "\n" not in str(error)
