"""What is measured about a run against ground truth, a file for each question."""
