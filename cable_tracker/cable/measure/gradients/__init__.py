"""Gradients of a frame along its scan lines."""
