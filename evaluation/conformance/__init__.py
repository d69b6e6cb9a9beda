"""The conformance kit: whether a backend, a robot and primitives keep what they promise."""
