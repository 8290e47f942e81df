from instrument_messages import camera_info

from cable_tracker.metric.sight import Sight
from cable_tracker.node_parameter_tables import CableVehicleParameters
from cable_tracker.sequences.bags.instruments import Instrument


class NotedCalibrations(Sight[CableVehicleParameters]):
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
    sight = NotedCalibrations()
    assert not sight.used
    for width in (640, 320):
        sight.take_message(Instrument.CAMERA_INFO, 0, camera_info(width))
    assert [each.image_size for each in sight.used] == [(640, 240), (320, 240)]


def test_what_the_user_gives_wins_over_messages(calibrations):
    given = calibrations["pinhole"]
    sight = NotedCalibrations(given)
    assert sight.used == [given]
    sight.take_message(Instrument.CAMERA_INFO, 0, camera_info(640))
    assert sight.used[-1] is given


def test_the_last_message_is_read_anew_as_rectified():
    sight = NotedCalibrations()
    sight.take_message(Instrument.CAMERA_INFO, 0, camera_info())
    sight.configure(CableVehicleParameters(image_is_rectified=True))
    assert [each.focal for each in sight.used] == [(280.0, 280.0), (250.0, 250.0)]
