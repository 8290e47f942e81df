"""Health of a node, as it reports it."""
