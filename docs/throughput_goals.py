"""Measure how many times faster than real time a processor surveys a recording.

    python docs/throughput_goals.py FOLDER [--length 38] [--rate 25] [--seed 3] [--runs 3]

A dive that lies in FOLDER already is used again. Once it is surveyed to load machine code, which
does not count. Pictures of events are not kept.
"""

from __future__ import annotations

import argparse
import statistics
import time
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2

from cable_tracker.simulation.instruments.survey_dive import usual_survey, write_survey_bag
from cable_tracker.survey.recording import SurveySettings, survey_recording


def main() -> None:
    """Simulate the dive if it is missing, survey it, and print seconds and their ratio."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--length", type=float, default=38.0)
    parser.add_argument("--rate", type=float, default=25.0)
    parser.add_argument("--seed", type=int, default=3)
    parser.add_argument("--runs", type=int, default=3)
    chosen = parser.parse_args()
    cv2.setNumThreads(1)  # As the command does: a processor for each recording.
    path = chosen.folder / f"dive_{chosen.seed}_{chosen.length:g}m_{chosen.rate:g}Hz"
    if not path.is_dir():
        chosen.folder.mkdir(parents=True, exist_ok=True)
        write_survey_bag(path, replace(usual_survey(chosen.length, chosen.seed), rate=chosen.rate))
    _times_real_time(path)
    times = [_times_real_time(path) for _ in range(chosen.runs)]
    print(f"{statistics.median(times):.1f} times real time in the median")


def _times_real_time(path: Path) -> float:
    begin = time.process_time()
    with TemporaryDirectory() as folder:
        settings = SurveySettings(pictures=False)
        surveyed = survey_recording(path, Path(folder), settings, lambda _: None, name=path.name)
    seconds = time.process_time() - begin
    print(f"{surveyed.seconds:.1f} s in {seconds:.2f} s of processor time", flush=True)
    return surveyed.seconds / seconds


if __name__ == "__main__":
    main()
