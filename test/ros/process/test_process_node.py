from __future__ import annotations

import io
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import redirect_stderr
from pathlib import Path
from typing import Any

import pytest

from cable_tracker.errors import RosError
from cable_tracker.ros import entry
from cable_tracker.ros.process.process_node import ProcessNode, run_node
from cable_tracker.ros.process.ros_context import PLAIN_FILE_ADVICE
from cable_tracker.ros.process.stop_request import StopRequest

SIGNALS = [signal.SIGINT, signal.SIGTERM]
"""Both are handled by the same function: each is sent in some of the tests for every change."""

NO_WATCH = "input_timeout:=3600.0"
NO_HASTE = "answer_timeout:=3600.0"
"""How long frames and answers stay away says how busy the machine is."""


def wait_until_it_listens_to_signals(run: Any) -> None:
    handled = 1 << (signal.SIGTERM - 1)
    status = Path(f"/proc/{run.process.pid}/status")
    run.wait_until(lambda: bool(_caught(status.read_text()) & handled), pause=0.001)


def _caught(status: str) -> int:
    line = next(line for line in status.splitlines() if line.startswith("SigCgt"))
    return int(line.split()[1], 16)


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
class TestSignals:
    @pytest.mark.parametrize("delay", [0.0, pytest.param(0.3, marks=pytest.mark.slow)])
    def test_a_signal_while_it_starts_ends_it(
        self, start_process: Callable[..., Any], delay: float
    ) -> None:
        run = start_process("tracker", NO_WATCH)
        wait_until_it_listens_to_signals(run)
        time.sleep(delay)
        code = run.end(signal.SIGTERM)
        unexpected = [line for line in run.words.splitlines() if not line.startswith("[INFO]")]
        assert (code, unexpected) == (0, [])

    @pytest.mark.parametrize(
        "signal_number", [pytest.param(signal.SIGINT, marks=pytest.mark.slow), signal.SIGTERM]
    )
    def test_a_signal_ends_the_running_tracker(
        self, start_process: Callable[..., Any], world: Any, namespace: str, signal_number: int
    ) -> None:
        run = start_process("tracker", NO_WATCH)
        wait_for(world, "tracker", namespace)
        code = run.end(signal_number)
        unexpected = [line for line in run.words.splitlines() if not line.startswith("[INFO]")]
        assert (code, unexpected) == (0, [])

    def test_a_signal_ends_a_tracker_in_the_middle_of_its_frames(
        self, start_process: Callable[..., Any], world: Any, make_dive: Callable[..., Path]
    ) -> None:
        from sensor_msgs.msg import JointState  # noqa: PLC0415

        states = world.listen(JointState, "state")
        source = f"source:={make_dive(10)}"
        # So many particles that the signal comes within a callback.
        tracker = start_process("tracker", "image_reliability:=reliable", "particle_count:=8000")
        replay = start_process("replay", source, "lockstep:=true", "loop:=true", NO_HASTE)
        world.spin(lambda: len(states) > 2)
        assert tracker.end(signal.SIGINT) == 0
        assert "Traceback" not in tracker.words
        assert replay.end(signal.SIGINT) == 0
        assert "Traceback" not in replay.words

    def test_a_signal_ends_a_replay_that_waits(
        self,
        start_process: Callable[..., Any],
        world: Any,
        make_dive: Callable[..., Path],
        namespace: str,
    ) -> None:
        run = start_process("replay", f"source:={make_dive(3)}", "lockstep:=true", NO_HASTE)
        wait_for(world, "replay", namespace)
        assert run.end(signal.SIGINT) == 0
        assert "Traceback" not in run.words
        assert "sent 0 frames" in run.words


def wait_for(world: Any, name: str, namespace: str) -> None:
    world.spin(lambda: (name, namespace) in world.me.get_node_names_and_namespaces())


@pytest.fixture
def run_here(
    namespace: str, capfd: pytest.CaptureFixture[str]
) -> Iterator[Callable[..., tuple[int, str]]]:
    """Run a node as its executable does, but in this process; exit code and errors."""
    before = {number: signal.getsignal(number) for number in SIGNALS}

    def run_and_read(name: str, *words: str) -> tuple[int, str]:
        code = entry.run(name, [name, "--ros-args", "-r", f"__ns:={namespace}", *words])
        return code, capfd.readouterr().err

    yield run_and_read
    for number, handler in before.items():
        signal.signal(number, handler)


class TestExitCodes:
    def test_a_replay_at_its_end_exits_with_0(
        self, start_process: Callable[..., Any], make_dive: Callable[..., Path]
    ) -> None:
        at_once = ("rate:=100.0", "wait_for_tracker:=false")
        run = start_process("replay", f"source:={make_dive(3)}", *at_once)
        assert run.end() == 0
        assert "sent 3 frames" in run.words

    def test_a_bad_parameter_ends_the_process_with_2_and_one_line(
        self, start_process: Callable[..., Any]
    ) -> None:
        run = start_process("tracker", "particle_count:=many")
        assert run.end() == 2
        lines = run.words.splitlines()
        assert len(lines) == 1
        assert lines[0].startswith("error: ") and "particle_count" in lines[0]

    def test_a_missing_recording_is_one_line_and_exit_code_2(
        self, run_here: Callable[..., tuple[int, str]], tmp_path: Path
    ) -> None:
        missing = tmp_path / "missing.mcap"
        code, errors = run_here("replay", "-p", f"source:={missing}")
        assert code == 2
        lines = errors.splitlines()
        assert len(lines) == 1
        assert lines[0].startswith(f"error: {missing}: there is no such file")

    @pytest.mark.parametrize(
        ("parameter", "name"),
        [
            ("particle_count:=[]", "particle_count"),
            ("response_table:=nowhere.json", "response_table"),
            ("use_sim_time:=3", "use_sim_time"),
        ],
    )
    def test_a_bad_parameter_is_one_line_and_exit_code_2(
        self, run_here: Callable[..., tuple[int, str]], parameter: str, name: str
    ) -> None:
        code, errors = run_here("tracker", "-p", parameter)
        assert code == 2
        lines = errors.splitlines()
        assert len(lines) == 1
        assert lines[0].startswith("error: ") and name in lines[0]

    def test_a_bad_parameter_file_is_reported_without_a_traceback(
        self, run_here: Callable[..., tuple[int, str]]
    ) -> None:
        code, errors = run_here("tracker", "-p", "particle_count:=[1.0, 2]")
        assert code == 2
        assert "error: ROS does not start; look at the --ros-args" in errors
        assert "Traceback" not in errors

    def test_a_plain_parameter_file_is_refused_with_the_form_for_nodes(
        self, run_here: Callable[..., tuple[int, str]], tmp_path: Path
    ) -> None:
        file = tmp_path / "vehicle.yaml"
        file.write_text("cable_height: 0.056\n")
        code, errors = run_here("tracker", "--params-file", str(file))
        assert code == 2
        assert PLAIN_FILE_ADVICE in errors

    def test_a_damaged_recording_ends_with_2_after_its_frames(
        self, run_here: Callable[..., tuple[int, str]], damaged_dive: Path
    ) -> None:
        given = (f"source:={damaged_dive}", "rate:=100.0", "wait_for_tracker:=false")
        code, errors = run_here("replay", *(word for each in given for word in ("-p", each)))
        assert code == 2
        assert f"error: {damaged_dive}: damaged" in errors
        assert "Traceback" not in errors


class Worker(ProcessNode):
    """Ends after some turns, or with an error."""

    def __init__(self, turns: int, error: Exception | None = None, **arguments: Any) -> None:
        super().__init__("worker", **arguments)
        self.turns = turns
        self.error = error
        self.destroyed = False

    def work(self) -> None:
        self.turns -= 1
        if self.turns <= 0:
            if self.error is not None:
                raise self.error
            self.finished = True

    def destroy_node(self) -> None:
        self.destroyed = True
        super().destroy_node()


class TestRunNode:
    def test_a_run_ends_with_its_node_and_destroys_it(self) -> None:
        made: list[Worker] = []

        def make(context: Any) -> Worker:
            made.append(Worker(3, context=context))
            return made[0]

        assert run_node(make, [], StopRequest()) == 0
        assert made[0].turns == 0
        assert made[0].destroyed

    def test_an_error_of_ours_is_one_line_and_exit_code_2(self) -> None:
        printed = io.StringIO()
        with redirect_stderr(printed):
            code = run_node(
                lambda context: Worker(1, RosError("no answer"), context=context),
                [],
                StopRequest(),
            )
        assert code == 2
        assert printed.getvalue() == "error: no answer\n"

    def test_an_error_of_the_middleware_is_one_line_and_exit_code_2(
        self, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
    ) -> None:
        # The wheels have no security: the middleware refuses to make a node with it.
        monkeypatch.setenv("ROS_SECURITY_ENABLE", "true")
        monkeypatch.setenv("ROS_SECURITY_STRATEGY", "Permissive")
        monkeypatch.setenv("ROS_SECURITY_KEYSTORE", str(tmp_path))
        (tmp_path / "enclaves").mkdir()
        printed = io.StringIO()
        with redirect_stderr(printed):
            code = run_node(lambda context: Worker(1, context=context), [], StopRequest())
        assert code == 2
        assert printed.getvalue().startswith("error: ROS ")
        assert len(printed.getvalue().splitlines()) == 1

    def test_another_error_is_not_hidden(self) -> None:
        with pytest.raises(ZeroDivisionError):
            run_node(
                lambda context: Worker(1, ZeroDivisionError(), context=context), [], StopRequest()
            )

    def test_a_request_to_stop_that_came_before_makes_no_node(self) -> None:
        stop = StopRequest()
        stop(signal.SIGTERM, None)

        def make(context: Any) -> Worker:
            raise AssertionError

        assert run_node(make, [], stop) == 0

    def test_a_context_shut_down_from_elsewhere_is_an_orderly_end(self) -> None:
        class Closing(Worker):
            def work(self) -> None:
                self.context.shutdown()

        assert run_node(lambda context: Closing(1, context=context), [], StopRequest()) == 0
