from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml

from cable_tracker import __version__
from cable_tracker.sequences.bags.convert import write_bag
from cable_tracker.simulation.scenario_dive import SimulationSettings, simulate

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]


def anchors_of(page: Path) -> set[str]:
    """Return the anchors of a page's headings, as forges make them."""
    headings = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    bare = (re.sub(r"[^\w\- ]", "", heading.lower()) for heading in headings)
    return {heading.strip().replace(" ", "-") for heading in bare}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    for link in re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8")):
        if "://" in link:
            continue
        name, _, anchor = link.partition("#")
        target = (page.parent / name).resolve() if name else page
        assert target.exists(), link
        assert not anchor or anchor in anchors_of(target), link


FOLDERS = ("cable_tracker", "test", "docs", "config", "launch")


def paths_named_in(text: str) -> Iterator[str]:
    """Yield the words in typewriter face that name a file of a kind that is kept here."""
    for quoted in re.findall(r"`([^`\n]+)`", text):
        for word in quoted.split():
            path = word.partition("::")[0]
            named = re.fullmatch(r"(?:[\w.-]+/)+[\w.-]+\.(?:py|md|yaml|xml|json|csv)", path)
            if named or re.fullmatch(rf"(?:{'|'.join(FOLDERS)})/[\w./-]*", path):
                yield path


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_files_and_folders_that_are_named_exist(page):
    for path in paths_named_in(page.read_text(encoding="utf-8")):
        # In test/fuzz/examples a folder stands for each target.
        candidates = (ROOT / path.removesuffix("/TARGET"), ROOT / "cable_tracker" / path)
        assert any(candidate.exists() for candidate in candidates), path


def test_a_path_that_leads_nowhere_is_found():
    assert list(
        paths_named_in("`cable/no.py` and `test/x.py::test_it`, `a/b`, `estimates.csv`")
    ) == [
        "cable/no.py",
        "test/x.py",
    ]


def test_the_readme_is_short_and_the_index_names_every_page():
    assert (ROOT / "README.md").stat().st_size <= 7000
    index = (ROOT / "docs" / "README.md").read_text(encoding="utf-8")
    pages = {page.name for page in (ROOT / "docs").glob("*.md")} - {"README.md"}
    assert pages <= set(re.findall(r"\]\(([\w.]+\.md)", index))


def test_the_examples_of_the_python_page_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_bag(
        tmp_path / "dive", simulate(SimulationSettings(frame_count=12, image_size=(160, 120)))
    )
    page = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
    code = "\n".join(re.findall(r"```python\n(.*?)```", page, re.DOTALL))
    exec(compile(code.replace("dive.mp4", "dive"), "python.md", "exec"), {})
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 13
    assert lines[0].startswith("0 INITIALISING")


def test_the_citation_has_the_version_and_licence_of_the_package():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert (citation["version"], citation["license"]) == (__version__, "Apache-2.0")
    assert {entry["type"] for entry in citation["references"]} == {"thesis", "article"}
