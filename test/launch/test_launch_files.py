"""PyPI has no `launch`: here the files can only be checked for syntax and for what they name."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
LAUNCH_FILES = sorted((ROOT / "launch").glob("*.launch.py"))


def strings_in(tree: ast.AST) -> set[str]:
    return {
        node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    }


def keywords_named(tree: ast.AST, name: str) -> set[str]:
    return {
        node.value.value
        for node in ast.walk(tree)
        if isinstance(node, ast.keyword) and node.arg == name
        if isinstance(node.value, ast.Constant)
    }


def test_there_are_launch_files():
    assert [path.name for path in LAUNCH_FILES] == ["replay.launch.py", "tracker.launch.py"]


@pytest.mark.parametrize("path", LAUNCH_FILES, ids=lambda path: path.name)
def test_a_launch_file_defines_what_launch_looks_for(path):
    tree = ast.parse(path.read_text(encoding="utf-8"), filename=str(path))
    functions = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
    assert "generate_launch_description" in functions


@pytest.mark.parametrize("path", LAUNCH_FILES, ids=lambda path: path.name)
def test_a_launch_file_names_our_package_and_its_executables(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    assert keywords_named(tree, "package") == {"cable_tracker"}
    assert keywords_named(tree, "executable") <= {"tracker", "replay"}


def test_replay_includes_a_launch_file_that_exists():
    named = {
        text
        for text in strings_in(ast.parse(LAUNCH_FILES[0].read_text(encoding="utf-8")))
        if text.endswith(".launch.py")
    }
    assert named == {"tracker.launch.py"}
