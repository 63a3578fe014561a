"""What a run leaves behind: results file, tables, figures, page."""
