"""Test whether the set-up is as dataset.yaml describes it: signs, zeros, conventions, units, labels and the order of the poses."""
