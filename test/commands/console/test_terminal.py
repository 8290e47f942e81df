from cable_tracker.commands.console.terminal import counted, progress_bar


def test_the_bar_moves_when_a_frame_is_done():
    with progress_bar("frames", 2) as progress:
        frames = counted("ab", progress)
        assert next(frames) == "a"
        assert progress.tasks[0].completed == 0
        assert next(frames) == "b"
        assert progress.tasks[0].completed == 1
        assert list(frames) == []
        assert progress.tasks[0].completed == 2
