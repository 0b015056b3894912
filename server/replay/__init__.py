"""`varil replay`: a stored trial simulated again, checked, and seen with another policy."""
