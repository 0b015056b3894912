"""What numbers become: figures as bytes, tables as rows, intervals from seeded draws."""
