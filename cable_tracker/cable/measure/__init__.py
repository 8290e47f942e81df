"""What a picture says about a cable at a place."""
