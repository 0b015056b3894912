"""What a trial leaves behind: its events and the inputs from which it can be replayed exactly."""
