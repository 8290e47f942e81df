"""How particles and groups of them are weighed: what is one cable, and how much speaks for it."""
