"""What the weighed particles of a frame say, and what they are held against."""
