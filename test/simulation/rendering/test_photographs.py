import cv2
import numpy as np
import pytest

from cable_tracker.errors import RecordingError
from cable_tracker.simulation.rendering.photographs import make_photographed_bed
from cable_tracker.simulation.rendering.texture import MARGIN
from cable_tracker.simulation.scenario_dive import simulate_scenario

pytestmark = pytest.mark.slow


def _bed(folder, tone=0.3):
    texture = make_photographed_bed(folder, 8, tone, np.random.default_rng(0))
    return texture.levels[0][MARGIN:-MARGIN, MARGIN:-MARGIN]


@pytest.fixture
def folder(tmp_path):
    rng = np.random.default_rng(5)
    for index in range(3):
        noise = cv2.GaussianBlur(rng.normal(0, 400, (120, 160)), (0, 0), 3) + 40 + 60 * index
        cv2.imwrite(str(tmp_path / f"{index}.png"), noise.clip(0, 255).astype(np.uint8))
    (tmp_path / "notes.txt").write_text("not a picture")
    (tmp_path / "broken.jpg").write_bytes(b"not a picture either")
    (tmp_path / "lost.jpg").symlink_to("nowhere.jpg")
    (tmp_path / "folder.jpg").mkdir()
    return tmp_path


@pytest.mark.parametrize("tone", [0.2, 0.5])
def test_photographs_become_an_even_bottom_of_the_tone_asked_for(folder, tone):
    bed = _bed(folder, tone)
    assert bed.mean() == pytest.approx(tone, rel=0.05)
    assert 0.15 < bed.std() / tone < 0.4
    quarters = [bed[:256, :256], bed[:256, 256:], bed[256:, :256], bed[256:, 256:]]
    assert np.ptp([quarter.mean() for quarter in quarters]) < 0.15 * tone


def test_the_bottom_repeats_without_a_seam(folder):
    bed = _bed(folder)
    steps = np.abs(np.diff(bed, axis=0)).mean(axis=1)
    assert np.abs(bed[0] - bed[-1]).mean() <= 1.5 * steps.max()


def test_a_folder_without_photographs_is_refused(tmp_path):
    with pytest.raises(RecordingError, match="holds no readable photographs"):
        _bed(tmp_path)
    with pytest.raises(RecordingError, match="is not a folder"):
        _bed(tmp_path / "missing")


def test_real_photographs_serve_as_a_bottom(real_footage):
    frame = next(simulate_scenario("S3", photographs=real_footage("seabed"))).frame
    plain = next(simulate_scenario("S3")).frame
    assert bytes(frame.image.data) != bytes(plain.image.data)
    assert frame.truth == plain.truth
