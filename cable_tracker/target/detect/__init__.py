"""Detectors: they propose outlines in whole pictures, and decide nothing."""
