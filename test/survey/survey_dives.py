"""A dive along a bent cable, without pictures: what the tracker would have said of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from cable_tracker.survey.forward_pass import ForwardDive
from cable_tracker.survey.frame_table import PROFILE_BINS, TRACKING, Samples
from cable_tracker.survey.memory_mapped import Disk
from cable_tracker.survey.trajectory import Trajectory, joined_trajectory

SPEED, RATE, LOOK = 0.5, 10.0, 0.7
START = 1_000_000_000
DISK = Disk()


@dataclass(frozen=True)
class Plan:
    """What a dive is like: lengths [m], standard deviations."""

    length: float = 40.0
    bend: float = 0.03
    hidden: Sequence[tuple[float, float]] = ()
    aside: float = 0.2
    noise: float = 0.02
    seed: int = 0
    wrong: Sequence[tuple[float, float]] = ()
    rope: Sequence[tuple[float, float]] = ()
    """Where something thinner is claimed instead, beside the cable."""
    rope_diameter: float = 0.06


def course(along: np.ndarray, bend: float) -> tuple[np.ndarray, np.ndarray]:
    """Return places and headings of a cable that bends to and fro."""
    wave = 2 * np.pi / 30.0
    amplitude = bend / wave**2
    heading = np.arctan(amplitude * wave * np.cos(wave * along))
    return np.column_stack((along, amplitude * np.sin(wave * along))), heading


def make_dive(plan: Plan, disk: Disk = DISK) -> ForwardDive:
    """Return a dive with claims of a noise that is alike over half a metre."""
    rng = np.random.default_rng(plan.seed)
    dive = ForwardDive("dive", disk)
    count = int(plan.length / SPEED * RATE)
    errors = np.zeros(2)
    for k in range(count):
        along = SPEED * k / RATE
        (place,), (heading,) = course(np.array([along]), plan.bend)
        beside = plan.aside * np.sin(2 * np.pi * along / 17.0)
        x, y = place + beside * np.array([-np.sin(heading), np.cos(heading)])
        stamp = START + round(k / RATE * 1e9)
        dive.poses.add(stamp, [x, y, heading, SPEED])
        row = dive.table.append()
        row["frame"], row["stamp"], row["look"], row["half_view"] = k, stamp, LOOK, 1.0
        row["altitude"] = 2.0
        keep = np.exp(-SPEED / RATE / 0.5)
        errors = keep * errors + np.sqrt(1 - keep**2) * rng.standard_normal(2)
        true = true_aside(np.array([x, y, heading]), plan.bend)
        ahead = along + LOOK
        on_rope = any(start <= ahead <= end for start, end in plan.rope)
        if not on_rope and any(start <= ahead <= end for start, end in plan.hidden):
            row["status"] = 2
            continue
        off = (
            1.2
            if on_rope
            else 0.6
            if any(start <= ahead <= end for start, end in plan.wrong)
            else 0.0
        )
        row["status"] = TRACKING
        row["aside"] = true[0] + plan.noise * errors[0] + off
        row["heading"] = true[1] + 0.01 * errors[1]
        row["aside_variance"], row["aside_heading"] = plan.noise**2, 0.0
        row["heading_variance"] = 1e-4
        row["diameter"] = plan.rope_diameter if on_rope else 0.16
        bins = np.linspace(LOOK + 0.8, LOOK - 0.8, PROFILE_BINS)
        row["profile_ahead"] = bins
        seen = [not any(a <= along + b <= e for a, e in plan.hidden) for b in bins]
        row["profile_score"] = np.where(seen, 3.0, 0.2)
    return dive


def true_aside(pose: np.ndarray, bend: float) -> tuple[float, float]:
    """Return place beside the look line, and direction from it, of the cable at a pose."""
    x, y, yaw = pose[:3].tolist()
    return _true_aside(x, y, yaw, bend)


@cache
def _true_aside(x: float, y: float, yaw: float, bend: float) -> tuple[float, float]:
    # Between two of these places the line is straight to a tenth of a millimetre.
    along = np.linspace(x - 2.0, x + 4.0, 121)
    places, headings = course(along, bend)
    cos, sin = np.cos(yaw), np.sin(yaw)
    apart = places - [x, y]
    ahead, aside = apart @ [cos, sin], apart @ [-sin, cos]
    return float(np.interp(LOOK, ahead, aside)), float(np.interp(LOOK, ahead, headings) - yaw)


def poses_of(dive: ForwardDive) -> Trajectory:
    return joined_trajectory(dive.poses, DISK)


def way(count: int = 400, turn: float = 0.0) -> np.ndarray:
    """x, y, yaw of a gentle bend, 10 times a second at 0.5 m/s."""
    yaw = turn + 0.2 * np.sin(np.arange(count) / 60.0)
    steps = 0.05 * np.column_stack((np.cos(yaw), np.sin(yaw)))
    return np.column_stack((np.cumsum(steps, axis=0), yaw))


def odometry(places: np.ndarray, stamps=None) -> Samples:
    samples = Samples(4, DISK)
    for k, (x, y, yaw) in enumerate(places):
        stamp = START + k * 100_000_000 if stamps is None else stamps[k]
        samples.add(stamp, [x, y, yaw, 0.5])
    return samples
