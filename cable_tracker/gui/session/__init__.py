"""What the tracking window watches and commands: a recording tracked here, or a live node."""
