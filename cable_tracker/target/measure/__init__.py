"""What a frame says about a target: appearance, scores of regions, peaks of the map, outlines."""
