"""What every kind of tracker needs: parameters, status, the succession of frames, rates."""
