"""Metres, and turns of the camera, from what was recorded beside the pictures."""
