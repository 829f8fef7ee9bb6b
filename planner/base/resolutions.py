"""The table of sampling resolutions, with units and reasons. Smaller numbers cost and find more.

"The smallest w along a path" is, in all reports, the smallest at states ``W_ALONG_PATH`` apart.
"""

# manipulability w, rad of joint motion between two states (the largest of any joint)
W_ALONG_PATH = 0.01  # reports on a finished path
W_AGAINST_FLOOR = 1e-3  # a finished path against the manipulability floor
W_IN_GROWTH = 0.1  # a motion against the floor while a roadmap grows; growth keeps 2 % above it
W_IN_COST = 0.1125  # largest distance of the states over which the cost of a motion is integrated
W_STATES_PER_EDGE = 9  # evenly spaced states of an edge in a roadmap, both ends included

# lengths, rad of joint motion between two points of the sum
TOOL_ALONG_EDGE = 0.05  # the tool's path along a roadmap edge

# contacts, metres: between two states no point of the robot moves farther than this
RECHECK = 1e-3  # second check of every finished path, by the other library
RECHECK_BY_BACKEND = 0.05  # check of it by the requested library
CLEARANCE_ALONG_PATH = 0.01  # reports of the clearance along a path
CLEARANCE_FIRST = 0.05  # first samples of `planner check` for the smallest clearance
MOTION_IN_GROWTH = 0.1  # motions of a tree, before they are proven together
MOTION_IN_FIRST_PATH, FINEST_IN_FIRST_PATH = 0.05, 0.0125  # RRTConnect; halved while its path has no proof

# proofs, metres of distance beyond the margin: closer motions stay undecided
PROOF = 1e-4  # halving an interval below this takes longer than it proves
PROOF_OF_CHECK = 2e-4  # in `planner check`, which reports undecided motions
EXTRA_CLEARANCE = 8e-3  # for motions that only improve a path: proofs of closer ones are slow

SHOWN_STATES = 241  # states of the motion that a page plays, evenly spaced in joint motion, both ends included
CLEARANCES_OF_MOTION = 61  # states of a motion, evenly spaced in time, at which its page shows the clearance
