from instrument_messages import camera_info

from cable_tracker.metric.instrument_fusion import InstrumentFusion
from cable_tracker.node_parameter_tables import CableVehicleParameters
from cable_tracker.sequences.bags.instruments import Instrument


class CalibrationAlone(InstrumentFusion[CableVehicleParameters]):
    """Takes no measurements."""

    def forget_all(self):
        pass

    def _take_measurement(self, instrument, stamp, message):
        pass


def fusion(given=None):
    return CalibrationAlone(CableVehicleParameters(), given)


def test_the_last_message_counts():
    told = fusion()
    assert told.calibration is None
    for width in (640, 320):
        told.take_message(Instrument.CAMERA_INFO, 0, camera_info(width))
        assert told.calibration.image_size == (width, 240)


def test_what_the_user_gives_wins_over_messages(calibrations):
    given = calibrations["pinhole"]
    told = fusion(given)
    assert told.calibration is given
    told.take_message(Instrument.CAMERA_INFO, 0, camera_info(640))
    assert told.calibration is given


def test_the_last_message_is_read_anew_as_rectified():
    told = fusion()
    told.take_message(Instrument.CAMERA_INFO, 0, camera_info())
    assert told.calibration.focal == (280.0, 280.0)
    told.configure(CableVehicleParameters(image_is_rectified=True))
    assert told.calibration.focal == (250.0, 250.0)
