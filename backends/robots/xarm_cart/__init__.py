"""A robot put together from parts: a cart, an arm that others described, a hand."""
