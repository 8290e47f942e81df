"""The filter of this project: several hypotheses, and whether there is a cable at all."""
