"""All settings of a tracker, their files and presets."""
