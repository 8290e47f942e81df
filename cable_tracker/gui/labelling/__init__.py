"""Labels of a recording: what they are, their files, and the window to draw them in."""
