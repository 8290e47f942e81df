from cable_tracker.benchmark.profiling import MOST_ROWS, profile_preset


def test_the_functions_that_take_most_come_first_and_are_named_without_folders(shown):
    rows = profile_preset("thesis", shown, 3)
    assert len(rows) == MOST_ROWS
    shares = [row.share for row in rows]
    assert shares == sorted(shares, reverse=True)
    assert 0.0 < sum(shares) <= 100.0
    assert {row.name for row in rows} == {"thesis"}
    assert any(row.function.startswith(("cable.", "particle_filter.")) for row in rows)
    assert not any("/" in row.function for row in rows)
