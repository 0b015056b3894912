"""Learning runs while people work: experts' sockets, the run, training in another process."""
