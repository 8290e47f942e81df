"""Messages of instruments, as far as their readers look at them."""

from types import SimpleNamespace

SIZE = (320, 240)
K = [280.0, 0.0, 159.5, 0.0, 280.0, 119.5, 0.0, 0.0, 1.0]
P = [250.0, 0.0, 159.5, 0.0, 0.0, 250.0, 119.5, 0.0, 0.0, 0.0, 1.0, 0.0]


def vector(x=0.0, y=0.0, z=0.0):
    return SimpleNamespace(x=x, y=y, z=z)


def camera_info(width=SIZE[0]):
    region = SimpleNamespace(width=0, height=0)
    return SimpleNamespace(
        width=width, height=SIZE[1], distortion_model="plumb_bob", d=[], k=K, p=P, roi=region,
        binning_x=0, binning_y=0,
    )  # fmt: skip


def range_message(metres):
    return SimpleNamespace(range=metres, min_range=0.1, max_range=30.0)


def imu(turn=0.0, *, measures_turns=True):
    covariance = [0.0 if measures_turns else -1.0] + [0.0] * 8
    return SimpleNamespace(
        orientation=SimpleNamespace(x=0.0, y=0.0, z=0.0, w=1.0), orientation_covariance=[0.0] * 9,
        angular_velocity=vector(z=turn), angular_velocity_covariance=covariance,
    )  # fmt: skip


def odometry(sway=0.0, turn=0.0):
    twist = SimpleNamespace(linear=vector(y=sway), angular=vector(z=turn))
    return SimpleNamespace(twist=SimpleNamespace(twist=twist, covariance=[0.0] * 36))
