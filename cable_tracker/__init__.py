"""Follow an underwater cable or pipeline by camera, with a particle filter."""

__version__ = "0.1.0"
