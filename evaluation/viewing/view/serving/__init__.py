"""Server of the page, and its access control."""
