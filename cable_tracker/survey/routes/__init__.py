"""Routes along a cable, what stands out on them, and those of several dives put together."""
