"""The filter of the thesis."""
