"""Metrics of a run against ground truth, a file for each question."""
