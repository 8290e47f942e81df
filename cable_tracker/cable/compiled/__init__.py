"""The inner loops, compiled; each module is the twin of one a level up."""
