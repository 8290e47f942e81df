"""The nodes that users run, and what they are made of."""
