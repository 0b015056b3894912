"""The protocol of a study: its steps, its orders and its questionnaires."""
