"""`make results`: from a plan fixed beforehand to docs/results.md."""
