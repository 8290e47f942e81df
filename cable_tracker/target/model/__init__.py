"""What a target is: pose, template of its shape, movement, what is said about it."""
