"""How the vehicle has moved between frames, and whether the picture bears it out."""
