"""Evidence: what the paper claims, reproduced, and what we claim, measured."""
