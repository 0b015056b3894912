"""`varil simulate` and `varil learn`: trials without a browser, over all cores or a cluster."""
