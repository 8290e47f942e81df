"""What a dive's pictures say, frame by frame: the forward pass, and the table that it writes."""
