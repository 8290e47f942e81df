"""Survey of tracked dives: their routes, events and a report."""
