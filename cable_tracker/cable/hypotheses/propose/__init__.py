"""How the particles of a frame are drawn, in rounds, measured, and weighed."""
