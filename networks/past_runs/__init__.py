"""Reading ended runs: their journal, their decisions in hindsight."""
