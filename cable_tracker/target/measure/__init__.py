"""What a frame says about a target: appearance, scores of regions, places, outlines."""
