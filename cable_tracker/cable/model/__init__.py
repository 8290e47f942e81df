"""The cable's state, how it moves, and what is said of it."""
