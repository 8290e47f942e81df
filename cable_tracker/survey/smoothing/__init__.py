"""The cable as the whole dive tells of it, from keyframes, by a smoother."""
