"""Watches of an input: times of arrival, gaps, pictures that stand still."""
