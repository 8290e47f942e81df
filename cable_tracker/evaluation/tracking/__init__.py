"""Track a recording, and write what came of it into a folder."""
