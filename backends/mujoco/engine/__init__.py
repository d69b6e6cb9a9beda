"""MuJoCo as an engine: its model, its state, and contacts, pins and pressing hands in it."""
