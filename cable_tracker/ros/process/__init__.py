"""The process that a node runs in: start, environment, signals, end."""
