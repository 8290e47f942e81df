"""What is one cable among the particles, how much speaks for it, and what corrects that."""
