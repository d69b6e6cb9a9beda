"""Books: what is known of them, and how they are returned to their shelves."""
