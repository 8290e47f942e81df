"""All detectors by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from cable_tracker.detection.detector import CableDetector
from cable_tracker.detection.hough import HoughDetector
from cable_tracker.detection.line_segments import LineSegmentDetector
from cable_tracker.detection.segmentation import SegmentationDetector
from cable_tracker.detection.texture import TextureDetector

DETECTORS: Mapping[str, Callable[..., CableDetector]] = MappingProxyType(
    {
        "hough": HoughDetector,
        "segmentation": SegmentationDetector,
        "lsd": LineSegmentDetector,
        "texture": TextureDetector,
    }
)
