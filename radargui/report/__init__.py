"""Write tables, figures, PDF and HTML of sessions."""
