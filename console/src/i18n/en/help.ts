export default {
  'help.title': 'Help',
  'help.intro':
    'Take control of a monitor, then hold the joystick or the arrow keys to move it: it moves for as long as you hold. To open a valve, hold its button for a second; one press closes it.',
  'help.stop': 'STOP: this monitor, or all on pages of the site. Works in every field and above every dialog',
  'help.move': 'Move the barrel while held (page Operate)',
  'help.nozzle': 'Narrow or widen the jet while held (page Operate)',
  'help.escape': 'Close a dialog; end drawing',
  'help.help': 'This help',
  'help.tab': 'The first press of Tab goes to STOP',
  'help.gamepad':
    'A gamepad moves the barrel too, on the page Operate: left stick the barrel, shoulder buttons the nozzle, B is STOP. What it holds ends when it sends nothing new for 2 s (stick) or 5 s (button, cross, stick at its end): release it and pull again.',
  'help.guide': 'Show the first steps',
  'help.hardware':
    'STOP and LOCKOUT are commands over a network. They do not replace an emergency stop, which is a device with its own wiring.',
};
