"""The experiments behind the project's claims, run by its developers."""
