"""How finely things are sampled, in one table, with units and reasons. A smaller number costs more and finds more.

"The smallest w along a path", wherever it is reported, is the smallest at states ``W_ALONG_PATH`` apart.
"""

# manipulability w, rad of joint motion between two states (the largest of any joint)
W_ALONG_PATH = 0.01  # what is reported along a finished path
W_AGAINST_FLOOR = 1e-3  # a finished path against the manipulability floor
W_IN_GROWTH = 0.1  # a motion against the floor while a roadmap grows; growth keeps 2 % above it
W_IN_COST = 0.1125  # the farthest apart that states are which a motion's cost is integrated over
W_STATES_PER_EDGE = 9  # evenly spaced states, both ends included, that a roadmap keeps of every edge

# lengths, rad of joint motion between the points that are summed over
TOOL_ALONG_EDGE = 0.05  # the tool's path along a roadmap edge

# contacts, metres: between two states no point of the robot moves farther than this
RECHECK = 1e-3  # the second look at every finished path, by the second checker
RECHECK_BY_BACKEND = 0.05  # and the look at it by the library that was asked for, beside that
CLEARANCE_ALONG_PATH = 0.01  # the clearance that is reported along a path
CLEARANCE_FIRST = 0.05  # first look of `planner check` for the smallest clearance, refined from there
MOTION_IN_GROWTH = 0.1  # a tree's motions, before they are proven many at a time
MOTION_IN_FIRST_PATH, FINEST_IN_FIRST_PATH = 0.05, 0.0125  # RRTConnect's; halved where what was found has no proof

# proofs, metres of distance beyond the margin: what comes closer is left undecided
PROOF = 1e-4  # halving an interval below this takes longer than it proves
PROOF_OF_CHECK = 2e-4  # in `planner check`, which says what is undecided
EXTRA_CLEARANCE = 8e-3  # for motions that only improve a path: passing closer is slow to prove too

SHOWN_STATES = 241  # states of the motion that a page plays, evenly spaced in joint motion, both ends included
CLEARANCES_OF_MOTION = 61  # states of a motion, evenly spaced in time, at which its page shows the clearance
