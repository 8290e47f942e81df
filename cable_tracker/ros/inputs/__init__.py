"""Subscriptions of a node, and what watches them: arrival, gaps, pictures that stand still."""
