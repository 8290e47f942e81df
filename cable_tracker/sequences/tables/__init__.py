"""Tables that are written beside a recording."""
