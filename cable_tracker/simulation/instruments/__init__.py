"""Instruments of a simulated vehicle, their readings as messages, and bags of them."""
