"""Many views of a target: what they hold, the files they come in, what is odd about them."""
