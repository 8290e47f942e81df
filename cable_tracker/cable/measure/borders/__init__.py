"""What the borders of a strip, and its skin, say of a cable: the learnt observation model."""
