"""Newton's iteration on the balance, and the linear systems that it solves."""
