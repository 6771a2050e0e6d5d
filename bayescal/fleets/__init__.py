"""Many cameras: which there are, how they are spread over processes, which of them are odd."""
