"""Simulated targets with an outline, in colour, with exact masks."""
