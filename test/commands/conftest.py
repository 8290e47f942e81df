from __future__ import annotations

import pytest

from cable_tracker import cli


@pytest.fixture
def command(monkeypatch, capsys, tmp_path):
    """Run `cable-tracker` in an empty folder; return its exit code, output and messages."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        monkeypatch.setattr("sys.argv", ["cable-tracker", *map(str, arguments)])
        with pytest.raises(SystemExit) as end:
            cli.main()
        printed = capsys.readouterr()
        return end.value.code or 0, printed.out, printed.err

    return run
