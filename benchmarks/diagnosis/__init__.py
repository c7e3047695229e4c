"""What does a rigid model lack? A task that others can run against: datasets, answers, the rules by which they are scored, and first rivals."""
