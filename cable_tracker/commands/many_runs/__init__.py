"""Many runs of `evaluate` and `loop`, and what is written of them."""
