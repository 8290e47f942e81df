from instrument_messages import camera_info

from cable_tracker.metric.instrument_fusion import InstrumentFusion
from cable_tracker.node_parameter_tables import CableVehicleParameters
from cable_tracker.sequences.bags.instruments import Instrument


class NotedCalibrations(InstrumentFusion[CableVehicleParameters]):
    """Notes what calibrations it is to use."""

    def __init__(self, given=None):
        self.used = []
        super().__init__(CableVehicleParameters(), given)

    def forget_all(self):
        pass

    def _take_calibration(self, calibration):
        self.used.append(calibration)

    def _take_measurement(self, instrument, stamp, message):
        pass


def test_the_last_message_counts():
    fusion = NotedCalibrations()
    assert not fusion.used
    for width in (640, 320):
        fusion.take_message(Instrument.CAMERA_INFO, 0, camera_info(width))
    assert [each.image_size for each in fusion.used] == [(640, 240), (320, 240)]


def test_what_the_user_gives_wins_over_messages(calibrations):
    given = calibrations["pinhole"]
    fusion = NotedCalibrations(given)
    assert fusion.used == [given]
    fusion.take_message(Instrument.CAMERA_INFO, 0, camera_info(640))
    assert fusion.used[-1] is given


def test_the_last_message_is_read_anew_as_rectified():
    fusion = NotedCalibrations()
    fusion.take_message(Instrument.CAMERA_INFO, 0, camera_info())
    fusion.configure(CableVehicleParameters(image_is_rectified=True))
    assert [each.focal for each in fusion.used] == [(280.0, 280.0), (250.0, 250.0)]
