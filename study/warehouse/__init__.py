"""The warehouse: halls, tasks, robots in motion, the human, and the compiled step that moves them."""
