"""What a survey writes: maps, tables, and a page."""
