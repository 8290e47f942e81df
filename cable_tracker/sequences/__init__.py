"""Input and output of frames: bags, videos, image folders, sequence files."""
