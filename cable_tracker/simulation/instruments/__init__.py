"""What the instruments of a simulated vehicle say, and bags of it."""
