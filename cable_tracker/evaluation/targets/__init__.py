"""How well targets are followed: by our filters, and by the trackers of OpenCV."""
