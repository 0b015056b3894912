"""The AR display: its elements, what its agents know, and the conditions that switch it."""
