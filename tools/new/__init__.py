"""`handcart new`: folders that work as they are, to begin from."""
