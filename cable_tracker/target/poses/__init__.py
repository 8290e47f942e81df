"""The filter of the preset `default`: particles are poses, weighed by learnt appearance."""
