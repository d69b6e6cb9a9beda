"""`handcart console`: the operator's page in the browser."""
