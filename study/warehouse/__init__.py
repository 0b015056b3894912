"""The warehouse: halls, tasks, robots in motion, the human, and the compiled step of it all."""
