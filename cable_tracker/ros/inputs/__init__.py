"""What watches an input: times of arrival, gaps, pictures that stand still."""
