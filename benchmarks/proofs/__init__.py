"""``benchmarks proofs``: our proofs of straight motions against HPP's, motion by motion."""
