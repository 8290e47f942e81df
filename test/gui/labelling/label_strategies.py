"""What the tests of labels draw their examples from."""

import math

from hypothesis import strategies as st

from cable_tracker.cable.model.state import CableState
from cable_tracker.gui.labelling.labels import WITHOUT_CABLE, FrameLabel, Origin

lengths = st.floats(-1e4, 1e4)
widths = st.floats(1.0, 1e3)
angles = st.floats(-math.pi / 2, math.pi / 2, exclude_min=True)
skews = st.floats(-math.pi / 4, math.pi / 4)
states = st.builds(CableState, lengths, angles, widths, skews)
frame_labels = st.just(WITHOUT_CABLE) | st.builds(FrameLabel, states, st.sampled_from(Origin))
label_maps = st.dictionaries(st.integers(0, 29), frame_labels, max_size=12)


def key_frame(distance=0.0):
    """Return the label of a key frame whose cable lies at a distance [px]."""
    return FrameLabel(CableState(distance, 0.1, 40.0))
