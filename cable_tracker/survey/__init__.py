"""From tracked dives to a route, events and a report."""
