## What several crates say.

# The mark between whole and decimal digits.
decimal-mark = .
