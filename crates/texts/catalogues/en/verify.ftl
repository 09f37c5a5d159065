## What the checks print for the documentation.

detected-head =
    | fault | reported by | severity | longest time | rows |
    | --- | --- | --- | --- | --- |
detected-without-row = Faults of the simulator that no row of a flag injects:
at-once = at once
seconds-behind-blank = {" "}s
