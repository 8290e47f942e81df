"""Between the server and browsers: access, pictures on their way, paths that users type."""
