from cable_tracker.commands.console.terminal import advance_to, counted, progress_bar


def test_the_bar_moves_when_a_frame_is_done():
    with progress_bar("frames", 2) as progress:
        frames = counted("ab", progress)
        assert next(frames) == "a"
        assert progress.tasks[0].completed == 0
        assert next(frames) == "b"
        assert progress.tasks[0].completed == 1
        assert list(frames) == []
        assert progress.tasks[0].completed == 2


def test_the_bar_stands_at_the_place_that_is_reached():
    with progress_bar("way [m]", 20) as progress:
        for place, shown in ((-1.2, 0), (7.6, 8), (7.4, 7)):
            advance_to(progress, place)
            assert progress.tasks[0].completed == shown
