"""Speed against accuracy: what each setting costs, what it buys, and what to take."""
