"""The two windows of the thesis, in a browser: watch and tune the filter, label recordings."""
