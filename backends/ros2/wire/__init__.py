"""The connection to topics, and the messages that pass over it."""
