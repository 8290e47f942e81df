"""The whole-image detectors by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from cable_tracker.detection.baselines.hough import HoughDetector
from cable_tracker.detection.baselines.line_segments import LineSegmentDetector
from cable_tracker.detection.baselines.segmentation import SegmentationDetector
from cable_tracker.detection.baselines.texture_detector import TextureDetector
from cable_tracker.detection.detector import CableDetector

DETECTORS: Mapping[str, Callable[..., CableDetector]] = MappingProxyType(
    {
        "hough": HoughDetector,
        "segmentation": SegmentationDetector,
        "lsd": LineSegmentDetector,
        "texture": TextureDetector,
    }
)
