"""Measurements that anyone can repeat: one row a case, kept in a flat file, and not measured again."""
