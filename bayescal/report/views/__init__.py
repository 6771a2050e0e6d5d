"""What results look like to people: blocks that the terminal and the page lay out alike."""
