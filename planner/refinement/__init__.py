"""Better paths from a path: refined, shortened and simplified, over proven motions only."""
