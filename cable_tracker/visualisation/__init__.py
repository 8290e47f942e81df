"""Pictures that show a person what the tracker believes."""
