"""What each threshold of the diagnosis decides: halved and doubled, one at a time, on blind sets."""
