"""The live page: obstacles and the goal are moved in the browser, and the path is planned anew."""
