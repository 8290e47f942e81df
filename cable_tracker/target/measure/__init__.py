"""Measurements of a target in a frame: appearance, scores of regions, outlines."""
