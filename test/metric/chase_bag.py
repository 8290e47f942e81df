"""A bag of a simulated vehicle that turns before a target, with its instruments."""

import math

from cable_tracker.sequences.bags.bag_writer import BagWriter
from cable_tracker.sequences.bags.frame_messages import write_frame
from cable_tracker.sequences.bags.rosbags_messages import RosbagsMessages
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.simulation.instruments.instrument_messages import (
    BASE,
    make_camera_info,
    make_imu,
    make_odometry,
)
from cable_tracker.simulation.targets.chase import ChaseSettings, ChaseWorld
from cable_tracker.simulation.vehicle import VelocityCommand

RATE = 12.5
READINGS = 4
"""Of the instruments for each frame."""


def write_chase_bag(path, frames, *, instruments=("camera_info", "odometry"), turn=0.5, tiny=None):
    """Write it, and return boxes and places of the target in base_link, frame by frame.

    One frame may be `tiny`, too small to be used.
    """
    world = ChaseWorld(
        ChaseSettings(seed=1, speed=0.0, image_width=320, image_height=240, rate=RATE)
    )
    factory, truths = RosbagsMessages(), []
    with BagWriter(path) as bag:
        for index in range(frames):
            stamp = 1_000_000_000 + round(index * 1e9 / RATE)
            view = world.view(world.state())
            truths.append((view.box, view.place))
            image = view.image[:2, :2] if index == tiny else view.image
            write_frame(bag, Frame(index, stamp, raw_from_array(image, "bgr8")))
            if "camera_info" in instruments:
                info = make_camera_info(
                    factory, make_header(factory, stamp, "camera"), world.camera
                )
                bag.write("/camera_info", "sensor_msgs/msg/CameraInfo", info, stamp)
            for reading in range(READINGS):
                now = stamp + round(reading * 1e9 / RATE / READINGS)
                header = make_header(factory, now, BASE)
                state = world.state()
                period = 1.0 / RATE / READINGS
                if "odometry" in instruments:
                    said = world.instruments.odometry(state, period)
                    message = make_odometry(factory, header, said)
                    bag.write("/odometry", "nav_msgs/msg/Odometry", message, now)
                if "imu" in instruments:
                    errors = world.instruments.errors
                    message = make_imu(factory, header, world.instruments.imu(state), errors)
                    bag.write("/imu", "sensor_msgs/msg/Imu", message, now)
                rate = turn * math.sin(2.0 * index / RATE)
                world.advance(VelocityCommand(0.0, 0.0, 0.0, rate), 5.0, period)
    return truths
