"""What people and machines read: tables, the result document, figures, run folders."""
