"""Pictures: the self-contained meshcat page, and figures by matplotlib, which load on first use."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, ["figures"])
