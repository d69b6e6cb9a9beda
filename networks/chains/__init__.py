"""A network as a Markov chain: probabilities and costs of its runs' ends."""
