from typer.testing import CliRunner

from cable_tracker.cli import app


def test_it_compiles_and_says_so():
    result = CliRunner().invoke(app, ["warm-up"])
    assert result.exit_code == 0
    assert "the inner loops are compiled" in result.output
