"""Which fit is shipped as ``after.json``: the effects that it contains, and the weights of its poses."""
