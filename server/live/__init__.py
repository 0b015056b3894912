"""The running trials: sockets, rooms, the clock that drives them, and who stores them."""
