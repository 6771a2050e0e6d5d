"""The public functions: points or arrays in, a comparison out. One module per kind of question."""
