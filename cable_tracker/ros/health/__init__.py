"""What a node says of its own health."""
