"""Pages of recordings whose paths are no UTF-8, as an old disk or another system names them."""

import os
import urllib.request

import cv2
import numpy as np
import pytest

pytest.importorskip("nicegui", reason="NICEGUI IS NOT INSTALLED: the pages are not tested")

from .conftest import Running


@pytest.mark.parametrize("command", ["gui", "label"])
def test_a_recording_in_a_folder_whose_name_is_no_utf8_is_shown(tmp_path, command):
    dive = tmp_path / os.fsdecode(b"caf\xe9") / "dive"
    dive.mkdir(parents=True)
    cv2.imwrite(str(tmp_path / "0.png"), np.zeros((48, 64), np.uint8))
    (tmp_path / "0.png").rename(dive / "0.png")
    running = Running([command, dive, "--port", "0"], tmp_path)
    try:
        with urllib.request.urlopen(running.url, timeout=60) as page:
            assert b"caf\\\\xe9" in page.read()
    finally:
        running.stop()
