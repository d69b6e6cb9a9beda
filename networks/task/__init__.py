"""From a task file to a checked network, and a robot that could start."""
