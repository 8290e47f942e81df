import numpy as np
import pytest

from cable_tracker.target.group import TargetGroup
from cable_tracker.target.model.start import TargetStart
from cable_tracker.target.parameters.parameters import TargetParameters

STEP = 40_000_000


def test_two_of_one_kind_are_both_kept(draw):
    def both(number):
        left, _ = draw(centre=(90 + number, 120), axes=(16, 12), seed=number)
        right, mask = draw(centre=(230 - number, 120), axes=(16, 12), seed=number + 100)
        return np.where(mask[..., None], right, left)

    starts = [TargetStart.from_box(x - 16, 108, x + 17, 133) for x in (90, 230)]
    group = TargetGroup(2, TargetParameters())
    for number, start in enumerate(starts):
        group.initialise(number, start)
    for number in range(12):
        estimates = group.process(both(number), (number + 1) * STEP)
    assert [each.status.value for each in estimates] == ["TRACKING"] * 2
    assert estimates[0].state[0] == pytest.approx(101 - 159.5, abs=4.0)
    assert estimates[1].state[0] == pytest.approx(219 - 159.5, abs=4.0)
    assert group.shares == pytest.approx([0.5, 0.5], abs=0.05)
