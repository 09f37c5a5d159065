## What can be broken in the simulator. A key is the kind and the name that lafet-sim gives it; a test of lafet-play
## compares them.

drive-motor-open = the motor circuit is open
drive-jam = something blocks it
drive-power-stage = the power stage is dead, and nothing diagnoses it
drive-runaway = the power stage is shorted: it turns at full speed, driven or not
drive-friction = heavy friction: it draws more current than it may
drive-flicker = heavy friction, and the current drops out of the readings now and then
drive-lag = the speed follows its command late
drive-dead-band = it does not turn at low speed
drive-droop = the load takes speed from it
drive-backlash = the gear has play
drive-stiff = thick grease: it draws more current than usual
drive-encoder-dead = the position no longer changes in the readings
drive-encoder-reversed = the position counts the wrong way
drive-encoder-fast = the position counts four times what it should
drive-encoder-jump = the position has jumped
drive-encoder-noise = the position is noisy
drive-encoder-fault = the position sensor reports a fault
drive-speed-dead = the speed sensor reads 0
drive-speed-reversed = the speed sensor has the wrong sign
drive-speed-fault = the speed sensor reports a fault
drive-min-switch = the switch at the lower, right, wider or stowed end is stuck on
drive-max-switch = the switch at the upper, left, narrower or deployed end is stuck on
drive-min-bounce = the switch at the lower, right, wider or stowed end bounces
drive-max-bounce = the switch at the upper, left, narrower or deployed end bounces

valve-motor-open = the motor circuit is open
valve-open-relay = the relay that opens is welded: it opens, driven or not
valve-jam = the plug is stuck
valve-open-switch = the circuit of the switch “open” is broken or shorted
valve-close-switch = the circuit of the switch “closed” is broken or shorted
valve-close-stuck = the switch “closed” is stuck on
valve-blocked = the hardware block is on
valve-open-bounce = the switch “open” bounces
valve-close-bounce = the switch “closed” bounces
valve-blocked-bounce = the contact of the hardware block bounces

unit-offline = its remote unit does not answer
unit-lossy = half of the exchanges with its remote unit are lost
unit-protocol = its remote unit breaks the protocol of the internal bus
unit-watchdog = its remote unit has been reset by the watchdog
unit-param-silent = its remote unit does not answer accesses to parameters
unit-param-incomplete = accesses to parameters of its remote unit end in RemotePaIncomplete
unit-param-bad-id = accesses to parameters of its remote unit end in RemotePaBadId
unit-param-bad-value = accesses to parameters of its remote unit end in RemotePaBadVal
unit-param-error = accesses to parameters of its remote unit end in RemotePaError

place-temperature = the temperature sensor does not answer
place-temperature-frozen = the temperature sensor stays at its value
place-temperature-drift = the temperature sensor drifts by 0.1 °C a second
place-heater = the heater’s circuit is broken

button-short = short circuit
button-break = broken wire
button-bounce = contact bounces and blips

single-pressure-break = Pressure sensor: the loop is broken, 0 mA
single-pressure-short = Pressure sensor: the loop is shorted, 28 mA
single-pressure-frozen = Pressure sensor: it stays at its value
single-pressure-drift = Pressure sensor: it drifts by 20 µA a second
single-flow-frozen = Flow meter: it stays at its value
single-flow-drift = Flow meter: it drifts by 1 l/s in five seconds
single-pump-off = Pump: no pressure
single-pump-weak = Pump: a quarter of its pressure
single-voltage-low = Supply: a third too low
single-voltage-high = Supply: a third too high
single-supply-dip = Supply: it gives way for 200 ms when a motor starts
single-supply-sag = Supply: it gives way as long as a motor runs
single-humidity = Humidity sensor: it does not answer
single-detector-dead = Fire detector: it does not answer
single-detector-saturated = Fire detector: saturated wherever it looks
single-dirty-lens = Fire detector: dirty glass
single-flash-read = Memory: it cannot be read
single-flash-write = Memory: it cannot be written
