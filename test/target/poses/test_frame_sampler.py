import pytest

from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.poses.frame_sampler import proposal_counts


@pytest.mark.parametrize("count", [10, 100, 501])
@pytest.mark.parametrize("has_peaks", [True, False])
def test_every_particle_is_drawn_by_one_part(count, has_peaks):
    counts = proposal_counts(TargetParameters(particle_count=count), has_peaks=has_peaks)
    assert sum(counts) == count
    assert min(counts.followed, counts.search + 1, counts.refined + 1) >= 1
    assert (counts.peaks > 0) is has_peaks


def test_of_a_handful_all_follow():
    parameters = TargetParameters(
        particle_count=10, place_share=0.35, search_share=0.25, refinement_share=0.35
    )
    assert proposal_counts(parameters, has_peaks=True) == (10, 0, 0, 0)
