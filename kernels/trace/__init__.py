"""Light over casters: rays followed through glass, mirrors and water until they end on a receiver."""
