"""Whole-image cable detectors: they give a prior, never the answer."""
