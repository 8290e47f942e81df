"""Model of a target: pose, template of its shape, movement, estimate."""
