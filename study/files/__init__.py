"""Study files: reading them, saying what is wrong with them, their schema, and the demo study's."""
