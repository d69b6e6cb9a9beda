"""The operator's connection to a run: stop, pause, permit, acknowledge."""
