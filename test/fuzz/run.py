"""Fuzz one target, guided by coverage: ``python test/fuzz/run.py TARGET --runs 100000``.

An input that breaks a promise is left in the folder given with ``--findings``; when the defect is
mended it goes to ``test/fuzz/examples/TARGET/`` under a name that says what it is.
"""

from __future__ import annotations

import argparse
import logging
import resource
import sys
import tempfile
from pathlib import Path

import atheris

# Imported before the rest is instrumented: Numba cannot compile instrumented functions.
import cable_tracker.target.tracker
import cable_tracker.trackers  # noqa: F401

INSTRUMENTED = ["cable_tracker", "rosbags", "mcap"]
MEMORY_LIMIT = 2048
"""More than this is a finding [MB]."""


def main() -> None:
    """Fuzz, and say how many inputs it were."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("target")
    parser.add_argument("--runs", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--timeout", type=int, default=30, help="longest time for one input [s]")
    parser.add_argument("--corpus", type=Path, help="folder in which new inputs are kept")
    parser.add_argument("--findings", type=Path, default=Path("fuzz_findings"))
    arguments = parser.parse_args()
    with atheris.instrument_imports(include=INSTRUMENTED):
        from targets import TARGETS  # noqa: PLC0415
    target = TARGETS[arguments.target]
    # Logging each refused picture would cost more than reading it.
    logging.disable(logging.CRITICAL)
    corpus = arguments.corpus or Path(tempfile.mkdtemp(prefix="cable_tracker_corpus_"))
    corpus.mkdir(parents=True, exist_ok=True)
    for name, data in target.seeds().items():
        (corpus / f"seed_{name}").write_bytes(data)
    arguments.findings.mkdir(parents=True, exist_ok=True)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    atheris.Setup(
        [
            sys.argv[0],
            str(corpus),
            f"-runs={arguments.runs}",
            f"-seed={arguments.seed}",
            f"-timeout={arguments.timeout}",
            f"-rss_limit_mb={MEMORY_LIMIT}",
            f"-artifact_prefix={arguments.findings}/{arguments.target}_",
            "-max_len=65536",
            "-print_final_stats=1",
            "-verbosity=0",
        ],
        target.run,
    )
    atheris.Fuzz()


if __name__ == "__main__":
    main()
