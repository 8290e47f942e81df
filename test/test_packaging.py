import re
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

import cable_tracker

ROOT = Path(__file__).resolve().parents[1]
SETUP = (ROOT / "setup.py").read_text(encoding="utf-8")
DDS = "{http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles}"


def requirement_names() -> list[str]:
    block = re.search(r"install_requires=\[(.*?)\]", SETUP, re.DOTALL).group(1)
    return re.findall(r'"([A-Za-z0-9_.-]+)', block)


def normalised(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def test_package_xml_has_the_version_of_the_package():
    package = ElementTree.parse(ROOT / "package.xml").getroot()
    assert package.findtext("version") == cable_tracker.__version__
    assert package.findtext("name") == "cable_tracker"


def test_the_maintainer_is_written_once():
    maintainer = ElementTree.parse(ROOT / "package.xml").getroot().find("maintainer")
    asked = [sys.executable, "setup.py", "-q", "--maintainer", "--maintainer-email"]
    told = subprocess.run(
        asked, cwd=ROOT, check=True, capture_output=True, text=True, timeout=600
    ).stdout
    assert told.split("\n")[-3:-1] == [maintainer.text, maintainer.get("email")]
    assert maintainer.get("email") not in SETUP


@pytest.mark.parametrize("name", requirement_names())
def test_every_requirement_is_pinned_and_has_a_reason(name):
    pinned = {
        normalised(line.split("==")[0])
        for line in (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
        if "==" in line
    }
    assert normalised(name) in pinned
    reasons = (ROOT / "docs" / "dependencies.md").read_text(encoding="utf-8")
    assert re.search(rf"^\| {re.escape(name)}\b", reasons, re.MULTILINE), name


def test_every_file_of_the_package_is_built_into_it(tmp_path):
    """What pip and colcon install; both build it by the same command."""
    build = [sys.executable, "setup.py", "-q", "build_py", "--build-lib", str(tmp_path)]
    subprocess.run(build, cwd=ROOT, check=True, capture_output=True, timeout=600)
    package = ROOT / "cable_tracker"
    wanted = {path.relative_to(ROOT) for path in package.rglob("*") if path.is_file()}
    built = {path.relative_to(tmp_path) for path in tmp_path.rglob("*") if path.is_file()}
    assert {path for path in wanted if "__pycache__" not in path.parts} == built
    assert Path("cable_tracker/cable/measure/borders/response_table.json") in built
    assert Path("cable_tracker/cable/measure/map/cable_map.onnx") in built


def test_the_dds_profile_has_room_for_large_frames_and_stays_on_loopback():
    profile = ElementTree.parse(ROOT / "config" / "fastdds_loopback.xml").getroot()
    sizes = [int(node.text) for node in profile.iter(f"{DDS}segment_size")]
    addresses = {node.text for node in profile.iter(f"{DDS}address")}
    assert min(sizes) >= 32 * 1024 * 1024
    assert addresses == {"127.0.0.1"}
    assert profile.find(f".//{DDS}useBuiltinTransports").text == "false"
