"""Clients of the tracker: the window, and the recording of a whole run."""
