"""The `varil` command: one file a verb, all of them brought together by `main`."""
