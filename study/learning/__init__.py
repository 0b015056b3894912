"""Visualization policies: what they are, how they are stored and learned."""
