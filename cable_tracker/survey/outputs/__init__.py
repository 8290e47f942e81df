"""Outputs of a survey: maps, tables, and a page."""
