"""The live page: obstacles and the goal are moved in the browser, and a path is planned after each change."""
