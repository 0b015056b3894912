"""What the administrators' live pages may know and do of the running trials, and their sockets."""
