"""The journal: every decision is written before it is acted on, and can be read back."""
