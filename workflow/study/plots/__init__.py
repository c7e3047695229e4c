"""Tables in, pictures out: nothing is computed here, and no picture is drawn from anything but a table."""
