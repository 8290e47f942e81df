"""Many tasks on one machine or many, with results on the disk. Knows no cable."""
