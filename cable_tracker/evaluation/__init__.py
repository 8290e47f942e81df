"""How good the tracker is: runs over whole recordings, metrics, and what they write."""
