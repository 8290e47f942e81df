"""Gradients and texture of a frame along its scan lines."""
