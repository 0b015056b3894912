"""The shell between the outside world and `study`."""
