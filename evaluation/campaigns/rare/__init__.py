"""Probabilities of rare run outcomes, estimated by multilevel splitting."""
