"""Recording of a run for `handcart view` and `handcart export`: writer and reader."""
