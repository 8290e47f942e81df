"""Scenarios: what they are described by, the built-in ones, and dives through them."""
