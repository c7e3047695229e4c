"""Which answers depend on each threshold of the diagnosis: halved and doubled, one at a time, on blind sets."""
