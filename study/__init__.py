"""What the experiment is: pure, without sockets, SQL, files or a wall clock."""
