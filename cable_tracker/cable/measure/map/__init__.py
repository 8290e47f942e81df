"""The map of a picture, which a network makes: where a cable may be."""
