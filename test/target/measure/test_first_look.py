import numpy as np

from cable_tracker.target.measure.first_look import learn_target
from cable_tracker.target.measure.working_frame import make_working_frame
from cable_tracker.target.parameters.parameters import TargetParameters


def test_what_goes_on_beyond_the_marked_box_is_not_taken_for_the_target():
    # A dark bar across the picture, of which only a part is marked.
    noise = np.random.default_rng(1).normal(0.0, 3.0, (240, 320))
    picture = np.full((240, 320), 120.0)
    picture[100:140] = 60.0
    frame = make_working_frame(np.clip(picture + noise, 0, 255).astype(np.uint8), 320)
    marked = np.zeros((240, 320), np.bool_)
    marked[100:140, 140:180] = True
    look = learn_target(frame, marked, TargetParameters(), is_exact=False)
    half_width, half_height = (each * look.template.size for each in look.template.extent(0.0))
    assert half_width < 20.0 * 1.3 + 2.0
    assert 17.0 < half_height < 23.0
