"""Build description, for pip and for colcon (ament_python)."""

from pathlib import Path
from xml.etree import ElementTree

from setuptools import find_packages, setup

PACKAGE = "cable_tracker"
ROOT = Path(__file__).parent
VERSION = {}
exec((ROOT / PACKAGE / "__init__.py").read_text(encoding="utf-8"), VERSION)
MAINTAINER = ElementTree.parse(ROOT / "package.xml").find("maintainer")

TEST = [
    "filterpy",
    "hypothesis",
    "particles",
    "pytest",
    "pytest-instafail",
    "pytest-timeout",
    "pytest-xdist",
]


def files(folder: str, pattern: str) -> list[str]:
    """Return the files of a folder, as paths relative to this file."""
    return sorted(
        str(path.relative_to(ROOT)) for path in (ROOT / folder).glob(pattern) if path.is_file()
    )


setup(
    name=PACKAGE,
    version=VERSION["__version__"],
    description="Follow an underwater cable or pipeline by camera, with a particle filter",
    long_description=(ROOT / "README.md").read_text(encoding="utf-8"),
    long_description_content_type="text/markdown",
    maintainer=MAINTAINER.text,
    maintainer_email=MAINTAINER.get("email"),
    license="Apache-2.0",
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={
        PACKAGE: ["py.typed"],
        f"{PACKAGE}.cable.measure.borders": ["*.json"],
        f"{PACKAGE}.cable.measure.map": ["*.onnx"],
        f"{PACKAGE}.evaluation": ["templates/*.j2"],
        f"{PACKAGE}.survey.outputs": ["*.j2", "*.js"],
        f"{PACKAGE}.gui": ["browser/*.js"],
        f"{PACKAGE}.gui.labelling": ["*.js", "*.css"],
        f"{PACKAGE}.gui.tracking": ["*.js", "*.css"],
    },
    python_requires=">=3.11",
    install_requires=[
        "Jinja2>=3.1",
        "numba>=0.59",
        "numpy>=1.26",
        "opencv-python-headless>=4.6",
        "matplotlib>=3.6",
        "lz4>=4",
        "dask>=2024.8",
        "distributed>=2024.8",
        "pyarrow>=15",
        "pyogrio>=0.9",
        "pyproj>=3.6",
        "shapely>=2",
        "threadpoolctl>=3.1",
        "av>=17",
        "pillow>=10.2",
        "mcap>=1.1",
        "PyYAML>=6",
        "rich>=13",
        "rosbags>=0.11",
        "typer>=0.9",
        "zstandard>=0.22",
    ],
    extras_require={
        "ros": ["ros-jazzy-rclpy[fastrtps]", "ros-jazzy-common-interfaces"],
        "gui": ["nicegui>=3"],
        "test": TEST,
        "dev": [
            *TEST,
            "atheris; python_version < '3.13'",
            "mypy",
            "playwright",
            "ruff",
            "scikit-image",
            "types-PyYAML",
        ],
        "train": ["onnx", "torch"],
    },
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        (f"share/{PACKAGE}/config", files("config", "*")),
        (f"share/{PACKAGE}/config/sros2", files("config/sros2", "*.xml")),
        (f"share/{PACKAGE}/launch", files("launch", "*.launch.py")),
    ],
    entry_points={
        "console_scripts": [
            "cable-tracker = cable_tracker.cli:main",
            "tracker = cable_tracker.ros.entry:tracker",
            "target_tracker = cable_tracker.ros.entry:target_tracker",
            "replay = cable_tracker.ros.entry:replay",
            "simulator = cable_tracker.ros.entry:simulator",
            "target_simulator = cable_tracker.ros.entry:target_simulator",
            "follower = cable_tracker.ros.entry:follower",
            "controller = cable_tracker.ros.entry:controller",
        ],
    },
    zip_safe=False,
)
