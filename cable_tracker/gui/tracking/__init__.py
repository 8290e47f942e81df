"""The window in which a filter is watched and tuned."""
