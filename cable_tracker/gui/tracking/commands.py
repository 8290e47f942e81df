"""Commands by buttons and keys."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from cable_tracker.gui.session.recording_session import RecordingSession
from cable_tracker.sequences.frame_access import BEYOND_ALL

SPEEDS = {
    "0.1": 0.1,
    "0.25": 0.25,
    "0.5": 0.5,
    "1": 1.0,
    "2": 2.0,
    "4": 4.0,
    "10": 10.0,
    "max": math.inf,
}
"""Speeds by their labels on the page."""

LEAP = 10
"""Frames of a long step."""


@dataclass(frozen=True, slots=True)
class KeyBinding:
    """Something that a key does.

    Attributes
    ----------
    name : str
        Name of the command in the page.
    keys : tuple of str
        Keys, as browsers name them.
    shown : str
        The keys, for people.
    description : str
        Description of the command for the help page.
    needs_player : bool
        Whether it makes sense on recordings alone.
    """

    name: str
    keys: tuple[str, ...]
    shown: str
    description: str
    needs_player: bool = False


COMMANDS = (
    KeyBinding("toggle", (" ", "k"), "space, k", "play or pause", True),
    KeyBinding("forward", ("ArrowRight",), "→", "one frame on", True),
    KeyBinding("back", ("ArrowLeft",), "←", "one frame back", True),
    KeyBinding("leap", ("Shift+ArrowRight",), "Shift →", f"{LEAP} frames on", True),
    KeyBinding("leap_back", ("Shift+ArrowLeft",), "Shift ←", f"{LEAP} frames back", True),
    KeyBinding("first", ("Home",), "Home", "first frame", True),
    KeyBinding("last", ("End",), "End", "last frame", True),
    KeyBinding("faster", ("+", "="), "+", "play faster", True),
    KeyBinding("slower", ("-", "_"), "−", "play more slowly", True),
    KeyBinding("reset", ("r",), "r", "forget everything: search anew"),
    KeyBinding("enable", ("e",), "e", "switch the tracker off or on"),
    KeyBinding("start", ("i",), "i", "type where the cable is"),
    KeyBinding("whole", ("0",), "0", "show the whole picture"),
    KeyBinding("search", ("/",), "/", "search a parameter"),
    KeyBinding("save", ("s",), "s", "save the parameters"),
    KeyBinding("open", ("o",), "o", "open a recording", True),
    KeyBinding("help", ("?", "h"), "?, h", "show these keys"),
)

DIALOGS = ("start", "save", "open", "help")
"""Commands that open a dialog."""

ZOOM_HELP = (
    ("wheel on the picture", "zoom"),
    ("Shift and drag", "move the zoomed picture"),
    ("Enter in a field", "set the parameter; Esc takes back what was typed"),
)

CLICK_HELP = ("click on the picture", "put the cable there, along the present direction")

POINTER_HELP = {
    "line": (
        CLICK_HELP,
        ("drag on the picture", "draw the centreline; the wheel changes the width, Esc cancels"),
        *ZOOM_HELP,
    ),
    "live line": (
        CLICK_HELP,
        ("drag on the picture", "draw the centreline; Esc cancels"),
        *ZOOM_HELP,
    ),
    "box": (("drag on the picture", "draw a box around the target; Esc cancels"), *ZOOM_HELP),
}
"""Help on the pointer for each shape that the user draws; a live node is told no width."""


def commands_for(*, is_player: bool, noun: str) -> tuple[KeyBinding, ...]:
    """Return the commands of a recording or of a live node; `noun` is what is followed."""
    return tuple(
        replace(command, description=command.description.replace("cable", noun))
        for command in COMMANDS
        if is_player or not command.needs_player
    )


def speed_label(speed: float) -> str:
    """Return the label of the speed that is nearest."""
    return min(SPEEDS, key=lambda label: 0.0 if SPEEDS[label] == speed else _apart(label, speed))


def _apart(label: str, speed: float) -> float:
    if math.isinf(SPEEDS[label]) or math.isinf(speed):
        return math.inf
    return abs(math.log(SPEEDS[label] / speed))


def command_player(player: RecordingSession, name: str, value: object = None) -> None:
    """Run the command of a key or a button of the transport bar; other names do nothing."""
    steps = {"forward": 1, "back": -1, "leap": LEAP, "leap_back": -LEAP}
    if name in steps:
        player.step(steps[name])
    elif name in ("play", "pause", "toggle"):
        wants_play = name == "play" or (name == "toggle" and not player.is_playing)
        (player.play if wants_play else player.pause)()
    elif name in ("first", "last", "seek"):
        _seek(player, name, value)
    elif name in ("faster", "slower", "speed"):
        _change_speed(player, name, value)


def _seek(player: RecordingSession, name: str, value: object) -> None:
    if name == "first":
        player.seek(0)
    elif name == "last":
        # How many frames there are may be known only at the end.
        player.seek(BEYOND_ALL)
    elif isinstance(value, int) and value >= 0:
        player.seek(value)


def _change_speed(player: RecordingSession, name: str, value: object) -> None:
    labels = list(SPEEDS)
    if name == "speed":
        player.set_speed(SPEEDS.get(str(value), player.speed))
        return
    index = labels.index(speed_label(player.speed)) + (1 if name == "faster" else -1)
    player.set_speed(SPEEDS[labels[min(max(index, 0), len(labels) - 1)]])
