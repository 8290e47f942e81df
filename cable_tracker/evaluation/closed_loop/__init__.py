"""A vehicle that follows the cable by the tracker's word: tables, totals, pictures."""
