"""The operator's line to a run: stop, pause, permit, acknowledge."""
