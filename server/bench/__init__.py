"""`varil bench`: what this machine carries, measured on the real code."""
