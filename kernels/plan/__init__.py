"""What a scene needs: the cheapest method, and the fewest terms, that meet the tolerance, and why."""
