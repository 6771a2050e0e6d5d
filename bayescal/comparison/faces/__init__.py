"""What results become for others: data frames, draws as ArviZ has them, a notebook's page."""
