"""Jobs: their state, their results, and cancelling them."""
