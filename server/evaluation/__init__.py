"""`varil evaluate`: figures and tables of what `varil learn` and `varil simulate` wrote."""
