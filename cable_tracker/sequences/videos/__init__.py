"""Videos as files: frames, their times, names as FFmpeg takes them."""
