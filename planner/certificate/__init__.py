"""Certificates: plans with a proof that a checker of one file accepts, without believing the planner."""

from planner.certificate.certificate import PROOF_NAME, Certificate, certificate_of, certificate_of_motion, verify

__all__ = ["PROOF_NAME", "Certificate", "certificate_of", "certificate_of_motion", "verify"]
