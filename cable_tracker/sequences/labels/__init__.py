"""What is known of the frames of a recording: true cables, and boxes around targets."""
