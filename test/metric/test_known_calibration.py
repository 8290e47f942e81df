from instrument_messages import camera_info

from cable_tracker.metric.known_calibration import KnownCalibration


def test_nothing_is_known_before_the_first_message():
    assert KnownCalibration(None, is_rectified=False).read() is None


def test_the_last_message_counts():
    known = KnownCalibration(None, is_rectified=False)
    for width in (640, 320):
        known.take_camera_info(camera_info(width))
        assert known.read().image_size == (width, 240)


def test_what_the_user_gives_wins_over_messages(calibrations):
    given = calibrations["pinhole"]
    known = KnownCalibration(given, is_rectified=False)
    known.take_camera_info(camera_info(640))
    assert known.read() is given


def test_the_last_message_is_read_anew_as_rectified():
    known = KnownCalibration(None, is_rectified=False)
    known.take_camera_info(camera_info())
    assert known.read().focal == (280.0, 280.0)
    known.configure(is_rectified=True)
    assert known.read().focal == (250.0, 250.0)
