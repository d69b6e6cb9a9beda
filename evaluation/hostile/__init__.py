"""Run folders that somebody damaged or made to do harm, and what reading them must not do."""
