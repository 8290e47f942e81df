"""Trackers as a recording session uses them."""
