"""The table of parameters, and named sets of them."""
