"""A cable on the sea bed, a vehicle that follows it, and exact ground truth."""
