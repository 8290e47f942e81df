"""Draw docs/images/frames.png, the frames and signs of docs/metric.md; run by hand, in seconds."""

from __future__ import annotations

import math
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle, Polygon, Rectangle

PICTURE = Path(__file__).resolve().parent / "images" / "frames.png"
SIZE, RESOLUTION = (11.0, 5.6), 110
VEHICLE, CABLE, MEASURE, SIGHT = "#d9dde2", "#b0702a", "#1f5fa8", "#3b8f4e"

HEADING = math.radians(24.0)
OFFSET, LOOK_AHEAD = 0.55, 1.5
ALTITUDE, CABLE_HEIGHT = 2.0, 0.12
CAMERA_X, CAMERA_Z, CAMERA_PITCH = 0.45, -0.12, math.radians(70.0)

Point = tuple[float, float]


def arrow(axes: Axes, start: Point, end: Point, colour: str, style: str = "-|>") -> None:
    """Draw an arrow."""
    axes.annotate(
        "",
        xy=end,
        xytext=start,
        arrowprops={"arrowstyle": style, "color": colour, "lw": 1.6, "shrinkA": 0, "shrinkB": 0},
    )


def label(axes: Axes, place: Point, text: str, colour: str = "black", side: str = "left") -> None:
    """Write beside a place, which is at this side of the text."""
    axes.text(*place, text, color=colour, fontsize=9.5, ha=side, va="center")


def prepared(axes: Axes, title: str, x: Point, y: Point) -> None:
    """Give a panel its title and limits, and nothing else."""
    axes.set_title(title, fontsize=11)
    axes.set_xlim(*x)
    axes.set_ylim(*y)
    axes.set_aspect("equal")
    axes.axis("off")


def draw_from_above(axes: Axes) -> None:
    """Draw offset and heading; to the right on paper is -y, upwards is x."""
    prepared(axes, "from above", (-2.6, 1.7), (-0.9, 2.9))
    hull = [(-0.3, -0.7), (0.3, -0.7), (0.3, 0.45), (0.0, 0.75), (-0.3, 0.45)]
    axes.add_patch(Polygon(hull, facecolor=VEHICLE, edgecolor="grey"))
    ends = [(-OFFSET - x * math.tan(HEADING), x) for x in (-1.0, 2.7)]
    axes.plot(*zip(*ends, strict=True), color=CABLE, lw=6, solid_capstyle="round", alpha=0.8)
    label(axes, (ends[1][0] + 0.15, 2.72), "cable, on the sea bed", CABLE)

    arrow(axes, (0.0, 0.0), (0.0, 2.3), "black")
    label(axes, (0.08, 2.3), "x, forward")
    arrow(axes, (0.0, 0.0), (-2.3, 0.0), "black")
    label(axes, (-2.35, 0.0), "y, left", side="right")
    axes.add_patch(Circle((0.0, 0.0), 0.05, color="black"))
    label(axes, (0.1, -0.15), "base_link")

    axes.plot([0.0, -OFFSET], [0.0, 0.0], color=MEASURE, lw=4)
    axes.plot([-OFFSET, -OFFSET], [0.0, 0.0], "o", color=MEASURE, ms=6)
    label(axes, (-OFFSET - 0.12, -0.22), "offset > 0", MEASURE, "right")
    ahead = -OFFSET - LOOK_AHEAD * math.tan(HEADING)
    axes.plot([0.0, ahead], [LOOK_AHEAD, LOOK_AHEAD], color=MEASURE, lw=1, ls="--")
    axes.plot([ahead], [LOOK_AHEAD], "o", color=MEASURE, ms=6)
    label(axes, (ahead - 0.12, LOOK_AHEAD), "offset ahead > 0", MEASURE, "right")
    arrow(axes, (0.5, 0.0), (0.5, LOOK_AHEAD), MEASURE, "<|-|>")
    label(axes, (0.58, LOOK_AHEAD / 2), "look_ahead", MEASURE)

    axes.plot([-OFFSET, -OFFSET], [0.0, 1.15], color="black", lw=0.8, ls=":")
    turn = math.degrees(HEADING)
    axes.add_patch(Arc((-OFFSET, 0.0), 1.9, 1.9, theta1=90, theta2=90 + turn, color=SIGHT, lw=2))
    label(axes, (-OFFSET - 0.62, 0.9), "heading > 0", SIGHT, "right")


def draw_from_the_side(axes: Axes) -> None:
    """Draw altitude, camera and line of sight; x to the right, z upwards."""
    prepared(axes, "from the left side", (-1.6, 2.9), (-2.45, 0.95))
    axes.add_patch(Rectangle((-1.6, -ALTITUDE - 0.35), 4.2, 0.35, facecolor="#e8dcc6", lw=0))
    axes.plot([-1.6, 2.6], [-ALTITUDE, -ALTITUDE], color="#8c7a55", lw=1.5)
    label(axes, (-1.5, -ALTITUDE - 0.2), "sea bed")
    height = -ALTITUDE + CABLE_HEIGHT
    axes.plot([-1.6, 2.6], [height, height], color=CABLE, lw=5, alpha=0.8)
    label(axes, (-0.93, height + 0.2), "axis of the cable,\ncable_height above", CABLE)

    hull = [(-0.7, -0.22), (0.5, -0.22), (0.75, 0.0), (0.5, 0.22), (-0.7, 0.22)]
    axes.add_patch(Polygon(hull, facecolor=VEHICLE, edgecolor="grey"))
    arrow(axes, (0.0, 0.0), (1.5, 0.0), "black")
    label(axes, (1.55, 0.0), "x, forward")
    arrow(axes, (0.0, 0.0), (0.0, 0.75), "black")
    label(axes, (0.08, 0.75), "z, up")
    axes.add_patch(Circle((0.0, 0.0), 0.04, color="black"))
    label(axes, (-0.06, 0.1), "base_link", side="right")
    arrow(axes, (-1.0, 0.0), (-1.0, -ALTITUDE), MEASURE, "<|-|>")
    axes.plot([-1.05, 0.0], [0.0, 0.0], color=MEASURE, lw=0.8, ls=":")
    label(axes, (-0.93, -1.0), "altitude", MEASURE)

    camera = (CAMERA_X, CAMERA_Z)
    reach = (-height + CAMERA_Z) / math.sin(CAMERA_PITCH)
    for turn, width in ((-22.0, 0.8), (0.0, 1.8), (22.0, 0.8)):
        pitch = CAMERA_PITCH + math.radians(turn)
        far = reach * math.sin(CAMERA_PITCH) / math.sin(pitch)
        end = (camera[0] + far * math.cos(pitch), camera[1] - far * math.sin(pitch))
        axes.plot([camera[0], end[0]], [camera[1], end[1]], color=SIGHT, lw=width)
    axes.add_patch(Circle(camera, 0.06, color=SIGHT))
    axes.plot([camera[0], camera[0] + 0.95], [camera[1]] * 2, color="black", lw=0.8, ls=":")
    axes.add_patch(
        Arc(camera, 1.2, 1.2, theta1=-math.degrees(CAMERA_PITCH), theta2=0, color=SIGHT, lw=2)
    )
    label(
        axes,
        (camera[0] + 0.6, camera[1] - 0.4),
        "camera_pitch: 90 deg is straight\ndown, here 70 deg",
        SIGHT,
    )
    label(axes, (camera[0] + 0.38, -1.35), "line of\nsight", SIGHT, "right")
    label(axes, (camera[0] - 0.1, -0.42), "camera_x, _y, _z", SIGHT, "right")


def frames_figure() -> Figure:
    """Return both panels."""
    figure = Figure(SIZE, dpi=RESOLUTION, layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2)
    draw_from_above(left)
    draw_from_the_side(right)
    return figure


def main() -> None:
    """Write the picture."""
    frames_figure().savefig(PICTURE)
    print(f"{PICTURE}: {PICTURE.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main()
