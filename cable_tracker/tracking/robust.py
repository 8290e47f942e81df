"""Robust statistics."""

GAUSSIAN_MAD = 1.4826
"""Standard deviation of a Gaussian over its median absolute deviation."""

RAYLEIGH_MEDIAN = 1.1774
"""Median length of a vector of two Gaussian components, over the standard deviation of each."""
