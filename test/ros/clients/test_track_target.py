import cv2
import pytest
from typer.testing import CliRunner

from cable_tracker.cli import app
from cable_tracker.simulation.targets.sequence import simulate_target


@pytest.fixture
def folder(tmp_path):
    path = tmp_path / "dive"
    path.mkdir()
    for index, frame in enumerate(simulate_target("near_surface", 2, 7)):
        cv2.imwrite(str(path / f"{index:03}.png"), frame.image)
    return path


@pytest.mark.parametrize("start", ["box", pytest.param("detect", marks=pytest.mark.slow)])
def test_over_dds_the_table_is_the_same(folder, tmp_path, start):
    (folder / "006.png").rename(folder / "206.png")
    box = next(simulate_target("near_surface", 2, 1)).box
    init = ",".join(str(side) for side in box) if start == "box" else start
    tables = []
    for name, flags in (("plain", []), ("ros", ["--ros"])):
        output = tmp_path / name
        arguments = ["target", folder, "--init", init, "--no-timing", "--output", output, *flags]
        result = CliRunner().invoke(app, [str(word) for word in arguments])
        assert result.exit_code == 0, result.output
        tables.append((output / "estimates.csv").read_bytes())
        assert {path.name for path in output.iterdir()} == {
            "estimates.csv", "overlay.webm", "overlay.png", "bag",
        }  # fmt: skip
    assert tables[0] == tables[1]
    assert tables[0].count(b"TRACKING") >= 4
    assert b"no frame for 8.040 s" in tables[0]
