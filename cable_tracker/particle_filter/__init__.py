"""A particle filter for any state and any model. Knows no cable and no image."""
