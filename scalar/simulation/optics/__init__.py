"""What a real line scanner adds to the truth, by physics or by a model of how it measures: a file an origin.

None of it is an effect of the arm. Each piece is off by default, and with all of them off a scene keeps its bytes.
"""
