"""`varil rehearse`: simulated participants through a running server's real pages and sockets."""
