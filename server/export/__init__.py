"""`varil export`: a study's data as one zip of tidy tables, written while they are read."""
