"""The picture that is measured: cleaned, evenly lit, made straight, of a moderate width."""
