"""What a page knows of what is tracked, a cable or a target: words, colours, parameters."""
