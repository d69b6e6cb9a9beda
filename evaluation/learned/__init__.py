"""How actions end and how long they take, learned from recorded campaigns: trials without a simulator."""
