import sys
from typing import Annotated, Optional

from cable_tracker.commands.console.lazy_group import with_optional_hints


def test_type_hints_of_commands_are_in_the_form_that_old_versions_of_typer_read():
    def command(output: Annotated[str | None, "help"], count: int, rate: float | None) -> None: ...

    assert with_optional_hints(command).__annotations__ == {
        "output": Annotated[Optional[str], "help"],  # noqa: UP045
        "count": int,
        "rate": Optional[float],  # noqa: UP045
        "return": type(None),
    }
    written = [str(hint) for hint in command.__annotations__.values()]
    assert not any(" | " in hint for hint in written if sys.version_info < (3, 14))
