"""Is what the robot is about to do proven safe? Verdicts on chunks of joint targets, in about half a millisecond."""
