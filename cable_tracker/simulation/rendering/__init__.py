"""Pictures of a sea bed and what lies on it, in turbid water."""
