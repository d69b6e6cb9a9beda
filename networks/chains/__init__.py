"""A network as a Markov chain: how runs end, and what they cost."""
