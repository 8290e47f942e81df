"""A tracker process is fed for a long time, with faults."""
