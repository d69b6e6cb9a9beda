"""Ground truth of books, and generated libraries."""
