"""What a lens is judged by: its density, evidence and draws, the error models averaged."""
