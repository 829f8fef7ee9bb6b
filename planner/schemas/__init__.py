"""What the files that the planner writes hold, as models that JSON schemas are made of: ``planner schema``.

Further keys may come with a later version of the planner, so they are allowed; a key that goes, or changes its meaning,
raises :data:`planner.base.formats.FORMAT_VERSION`.
"""
