"""Bearing, range and size of a target."""
