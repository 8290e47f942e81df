"""The commands of `cable-tracker dev`, for those who develop the package."""
