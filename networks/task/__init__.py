"""Reading of a task file into a checked network, and into a robot that could start."""
