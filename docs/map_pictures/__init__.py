"""Pictures for `train_cable_map.py`."""
