"""Pictures: the self-contained meshcat page. Nobody below imports this package."""
