"""Certificates: plans with a proof that a checker of one file verifies without the planner."""

from planner.certificate.certificate import PROOF_NAME, Certificate, make_certificate, make_motion_certificate, verify

__all__ = ["PROOF_NAME", "Certificate", "make_certificate", "make_motion_certificate", "verify"]
