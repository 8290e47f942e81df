"""What prediction is made of: where a cable may be before a frame is looked at."""
