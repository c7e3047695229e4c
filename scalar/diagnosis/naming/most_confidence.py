"""The largest confidence that a rule allows in a name (``limits_of_names``), as one of three steps."""

from __future__ import annotations

ONE_OF_TWO = 0.5
"""The cause is the named one or another one that explains the data as well, which the rule's reason states. Chosen, not fitted: with it, a name has
less than the least confidence that a name needs, and is reported as structure that is most like it."""
NOT_SURE = 0.65
"""The named cause is the more probable one, but has to be confirmed before anything is repaired: more than a name needs, less than a sure one has. Of
53 jitters with a confidence of 0.8 or more, 34 were right: the trials to which the confidence was fitted, and three later exams, none of whose
arms had a jitter. None of these sets has returns to the same poses. Where a tilt between axes is listed with a name, the same is chosen."""
NEARLY_SURE = 0.75
"""The named cause is usually right on these grounds, but not as often as a sure name has to be. Chosen: of 109 names of what gives way that were
found together with unmodelled structure in nine simulated exams, 89 were right."""
