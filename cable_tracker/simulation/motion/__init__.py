"""How the vehicle, and with it the cable in the image, moves."""
