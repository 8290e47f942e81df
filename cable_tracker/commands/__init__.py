"""The commands of `cable-tracker`, one file each."""
