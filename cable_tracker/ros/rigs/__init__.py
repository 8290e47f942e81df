"""Rigs that test and measure the nodes; no part of what runs on a vehicle."""
