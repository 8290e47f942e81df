"""A simulated vehicle follows a cable or a target by what the tracker publishes."""
