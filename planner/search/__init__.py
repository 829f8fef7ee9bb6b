"""The field, its path, and a second look at the path; what fails is removed and the field heals."""
