"""What pages, rooms, programs and verbs ask of the store: each question is one transaction."""
