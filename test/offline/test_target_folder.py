from __future__ import annotations

import numpy as np

from cable_tracker.offline.results import WantedResults
from cable_tracker.offline.target_folder import TargetFolder
from cable_tracker.offline.target_table import HEADER, METRES_HEADER, TargetClaim, TargetRow
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.tables.csv_tables import csv_text
from cable_tracker.sequences.tables.stored_rows import BLOCK

TABLES_ALONE = WantedResults(video=False, bag=False, pictures=False)


def claim_of(numbers):
    x = [float(number) for number in numbers]
    return TargetClaim(tuple(x[:6]), (x[6], x[7]), tuple(x[10:14]), x[14])


def filled(path, rows, metres):
    """Write a folder of refused frames."""
    picture = raw_from_array(np.zeros((2, 2), np.uint8), "mono8")
    with TargetFolder(path, wanted=TABLES_ALONE) as results:
        for row in rows:
            results.add(Frame(row.frame, row.stamp, picture), row, None)
        for facts in metres:
            results.metres.append(facts)
    return results


def test_tables_longer_than_what_is_kept_in_memory_are_written_whole(tmp_path):
    count = 2 * BLOCK + 3
    rows = [TargetRow(k, k, "TRACKING", claim_of(np.arange(15.0) / 7 + k)) for k in range(count)]
    metres = [tuple(f"{k}.{column}" for column in METRES_HEADER) for k in range(count)]
    results = filled(tmp_path / "out", rows, metres)
    assert list(results.rows) == rows
    estimates = csv_text(HEADER, [row.cells() for row in rows])
    assert (tmp_path / "out/estimates.csv").read_bytes() == estimates.encode()
    assert (tmp_path / "out/metres.csv").read_bytes() == csv_text(METRES_HEADER, metres).encode()
    assert {file.name for file in (tmp_path / "out").iterdir()} == set(results.names)


def test_without_metres_there_is_no_table_of_them(tmp_path):
    results = filled(tmp_path / "out", [TargetRow(0, 0, "REFUSED")], [])
    assert results.names == ["estimates.csv"]
    assert not (tmp_path / "out/metres.csv").exists()
