"""Settings for all tests."""

from hypothesis import settings

# The first call of a compiled function takes seconds, and no test is about time.
settings.register_profile("untimed", deadline=None)
settings.load_profile("untimed")
